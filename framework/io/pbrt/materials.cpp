// Materials by pbrt's names. Roughness becomes GGX's alpha as each version remaps it, unless "remaproughness" is false; alphas
// below 0.001 are perfectly smooth, as in version 4.

#include "framework/io/pbrt/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// pbrt-v3's TrowbridgeReitzDistribution::RoughnessToAlpha.
float version3_alpha(float roughness) {
  const float x = std::log(std::max(roughness, 1e-3f));
  return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

}  // namespace

vec2 PbrtReader::roughness_alpha(const PbrtParams& params, float otherwise, bool version3) {
  const float both = number(params, "roughness", otherwise, 0, 1);
  const vec2 roughness(number(params, "uroughness", both, 0, 1), number(params, "vroughness", both, 0, 1));
  vec2 alpha = roughness;
  if (params.boolean("remaproughness", true))
    for (int i = 0; i < 2; ++i) alpha[i] = version3 ? version3_alpha(roughness[i]) : std::sqrt(roughness[i]);
  if (std::max(alpha.x, alpha.y) < 1e-3f) return vec2(0);
  return glm::max(alpha, vec2(1e-4f));
}

float PbrtReader::isotropic_alpha(const PbrtParams& params, float otherwise, bool version3) {
  const vec2 alpha = roughness_alpha(params, otherwise, version3);
  if (alpha.x != alpha.y)
    params.fail(params.has("uroughness") ? "uroughness" : "vroughness",
                "differs from the other: only conductors may be anisotropic");
  return alpha.x;
}

float PbrtReader::refractive_index(const PbrtParams& params) {
  std::vector<std::string> names;
  if (const auto name = params.named_spectrum("eta")) {
    for (const GlassIndex& glass : glasses()) {
      names.emplace_back(glass.name);
      if (*name != glass.name) continue;
      warn(params.where("eta"),
           fmt::format("'{}' has the index {} at every wavelength: there is no dispersion", *name, glass.eta));
      return glass.eta;
    }
    throw Error(params.where("eta"), fmt::format("{}: {}", params.owner(), unknown_name("glass", *name, names)));
  }
  return number(params, "eta", number(params, "index", 1.5f, 1.0001f, 10), 1.0001f, 10);
}

Material PbrtReader::make_diffuse(const PbrtParams& params, std::string_view name, bool& textured) {
  if (name == "Kd" && number(params, "sigma", 0, 0, 90) != 0)
    params.fail("sigma", "is not supported: only Lambertian surfaces are");
  return Diffuse{textured_colour(params, name, Rgb(0.5f), textured)};
}

Material PbrtReader::make_conductor(const PbrtParams& params, bool version3) {
  Conductor conductor;
  const MetalIndex& copper = metals()[3];
  conductor.eta = params.colour("eta", ColourUse::index).value_or(copper.eta);
  conductor.k = params.colour("k", ColourUse::index).value_or(copper.k);
  if (!version3 && params.has("reflectance")) {
    if (params.has("eta") || params.has("k")) params.fail("reflectance", "cannot stand beside eta and k");
    // The index that has this reflectance at normal incidence with a real part of 1, as pbrt-v4 chooses it.
    const Rgb r = glm::min(colour(params, "reflectance", Rgb(0), ColourUse::reflectance), Rgb(0.9999f));
    conductor.eta = Rgb(1);
    conductor.k = 2.0f * glm::sqrt(r) / glm::sqrt(1.0f - r);
  }
  for (int c = 0; c < 3; ++c)
    if (conductor.eta[c] == 0 && conductor.k[c] == 0) params.fail("eta", "and 'k' are both 0 in a channel");
  conductor.alpha = roughness_alpha(params, version3 ? 0.01f : 0, version3);
  return conductor;
}

Material PbrtReader::make_mirror(const PbrtParams& params) {
  Conductor mirror;
  mirror.tint = colour(params, "Kr", Rgb(0.9f), ColourUse::reflectance);
  mirror.ideal = true;
  return mirror;
}

Material PbrtReader::make_glass(const PbrtParams& params) {
  Dielectric glass;
  glass.reflect_tint = colour(params, "Kr", Rgb(1), ColourUse::reflectance);
  glass.transmit_tint = colour(params, "Kt", Rgb(1), ColourUse::reflectance);
  glass.eta = refractive_index(params);
  // Version 3 takes glass without roughness as smooth before it remaps.
  bool rough = false;
  for (const char* name : {"roughness", "uroughness", "vroughness"}) rough |= number(params, name, 0, 0, 1) > 0;
  const float alpha = isotropic_alpha(params, 0, true);
  glass.alpha = rough ? alpha : 0;
  return glass;
}

Material PbrtReader::make_dielectric(const PbrtParams& params) {
  Dielectric dielectric;
  dielectric.eta = refractive_index(params);
  dielectric.alpha = isotropic_alpha(params, 0, false);
  return dielectric;
}

Material PbrtReader::make_plastic(const PbrtParams& params, bool& textured) {
  const Rgb specular = colour(params, "Ks", Rgb(0.25f), ColourUse::reflectance);
  if (specular != Rgb(0.25f)) params.fail("Ks", "other than 0.25 is not supported: the coat is a plain dielectric");
  warn(params.where(),
       params.owner() + ": is a diffuse base under a dielectric coat that conserves energy, not pbrt-v3's sum of two lobes");
  Plastic plastic;
  plastic.reflectance = textured_colour(params, "Kd", Rgb(0.25f), textured);
  plastic.alpha = isotropic_alpha(params, 0.1f, true);
  return plastic;
}

Material PbrtReader::make_coated_diffuse(const PbrtParams& params, bool& textured) {
  Plastic plastic;
  plastic.reflectance = textured_colour(params, "reflectance", Rgb(0.5f), textured);
  plastic.eta = refractive_index(params);
  plastic.alpha = isotropic_alpha(params, 0, false);
  if (!is_black(colour(params, "albedo", Rgb(0), ColourUse::reflectance)))
    params.fail("albedo", "is not supported: nothing scatters inside the coat");
  warn(params.where(), params.owner() + ": light between coat and base is summed in closed form, not sampled");
  params.ignore({"thickness", "g", "maxdepth", "nsamples"});  // of a clear coat, or of pbrt's sampling
  return plastic;
}

PbrtReader::MaterialEntry PbrtReader::make_material(const std::string& type, const PbrtParams& params) {
  for (const std::string_view bump : {"displacement", "bumpmap", "normalmap"})
    params.reject(bump, "surfaces are not displaced");
  if (type.empty() || type == "interface" || type == "none")
    throw Error(params.where(), fmt::format("material '{}' is not supported: there are no participating media to bound", type));
  MaterialEntry entry;
  bool& textured = entry.textured;
  if (type == "diffuse")
    entry.material = make_diffuse(params, "reflectance", textured);
  else if (type == "matte")
    entry.material = make_diffuse(params, "Kd", textured);
  else if (type == "mirror")
    entry.material = make_mirror(params);
  else if (type == "conductor" || type == "metal")
    entry.material = make_conductor(params, type == "metal");
  else if (type == "dielectric")
    entry.material = make_dielectric(params);
  else if (type == "glass")
    entry.material = make_glass(params);
  else if (type == "coateddiffuse")
    entry.material = make_coated_diffuse(params, textured);
  else if (type == "plastic")
    entry.material = make_plastic(params, textured);
  else {
    const std::vector<std::string> known{"diffuse",    "matte", "mirror",        "conductor", "metal",
                                         "dielectric", "glass", "coateddiffuse", "plastic"};
    throw Error(params.where(), unknown_name("material", type, known));
  }
  params.finish();
  return entry;
}

void PbrtReader::material(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Material");
  const PbrtParams params(lexer, titled(token.text, type), where);
  materials_.push_back(make_material(type, params));
  attributes_.material = static_cast<std::uint32_t>(materials_.size() - 1);
}

void PbrtReader::make_named_material(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "MakeNamedMaterial");
  const PbrtParams params(lexer, titled(token.text, name), where);
  if (named_materials_.contains(name)) throw Error(where, fmt::format("material '{}' is defined twice", name));
  const std::string type = params.string("type", "");
  if (type.empty()) params.fail("type", "is missing: the kind of material");
  materials_.push_back(make_material(type, params));
  named_materials_.emplace(name, static_cast<std::uint32_t>(materials_.size() - 1));
}

void PbrtReader::named_material(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "NamedMaterial");
  const auto found = named_materials_.find(name);
  if (found == named_materials_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, entry] : named_materials_) names.push_back(known);
    throw Error(where, unknown_name("named material", name, names));
  }
  attributes_.material = found->second;
}

std::uint32_t PbrtReader::scene_material(std::uint32_t index) {
  MaterialEntry& entry = materials_[index];
  if (!entry.scene_index) {
    entry.scene_index = static_cast<std::uint32_t>(scene_.materials.size());
    scene_.materials.push_back(entry.material);
  }
  return *entry.scene_index;
}

}  // namespace etendue
