// Materials by pbrt's names. Roughness becomes GGX's alpha as each version remaps it, unless "remaproughness" is false; alphas
// below 0.001 are perfectly smooth, as in version 4.

#include "framework/core/elementary.h"
#include "framework/io/gzip.h"
#include "framework/io/image/gamma.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// pbrt-v3's TrowbridgeReitzDistribution::RoughnessToAlpha.
float version3_alpha(float roughness) {
  const float x = math::log(std::max(roughness, 1e-3f));
  return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

}  // namespace

vec2 PbrtReader::roughness_alpha(const PbrtParams& params, float otherwise, bool version3, RoughnessBy by) {
  const auto read = [&](const char* name, float if_not, RoughnessBy unless) {
    if (!version3_ || by != unless) return number(params, name, if_not, 0, 1);
    if (params.has(name))
      warn(params.where(name), fmt::format("{}: '{}' has no effect, as in pbrt-v3, which expects {}", params.owner(), name,
                                           by == RoughnessBy::axis ? "'uroughness' and 'vroughness'" : "'roughness'"));
    params.ignore({name});
    return if_not;
  };
  const float both = read("roughness", otherwise, RoughnessBy::axis);
  const vec2 roughness(read("uroughness", both, RoughnessBy::one), read("vroughness", both, RoughnessBy::one));
  vec2 alpha = roughness;
  if (params.boolean("remaproughness", true))
    for (int i = 0; i < 2; ++i) alpha[i] = version3 ? version3_alpha(roughness[i]) : std::sqrt(roughness[i]);
  if (std::max(alpha.x, alpha.y) < 1e-3f) return vec2(0);
  return glm::max(alpha, vec2(1e-4f));
}

float PbrtReader::isotropic_alpha(const PbrtParams& params, float otherwise, bool version3, RoughnessBy by) {
  const vec2 alpha = roughness_alpha(params, otherwise, version3, by);
  if (alpha.x != alpha.y)
    approximate(params.where(params.has("uroughness") ? "uroughness" : "vroughness"),
                "a roughness that differs from the other: only conductors may be anisotropic",
                "their geometric mean: highlights are round");
  return std::sqrt(alpha.x * alpha.y);
}

// What is as dense as its surroundings refracts nothing, rough or not.
float smooth_where_even(float alpha, float eta) { return std::abs(eta - 1) < 1e-3f ? 0 : alpha; }

float PbrtReader::refractive_index(const PbrtParams& params, float least, float otherwise, std::string_view param) {
  std::vector<std::string> names;
  const auto even = [&](const std::string& what, float eta) {
    warn(params.where(param), fmt::format("{} has the index {:.5g} at every wavelength: there is no dispersion", what, eta));
    return eta;
  };
  const auto name = params.named_spectrum(param);
  if (!version3_ && params.is_spectrum(param) && (!name || name->find('.') != std::string::npos)) {
    const float eta = mean_component(*params.colour(param, ColourUse::index));
    if (!(eta >= least && eta <= 10)) params.fail(param, fmt::format("is {} on average; expected {} to 10", eta, least));
    return even(name ? quote(*name) : params.owner(), eta);
  }
  if (name) {
    for (const GlassIndex& glass : glasses()) {
      names.emplace_back(glass.name);
      if (*name == glass.name) return even(quote(*name), glass.eta);
    }
    throw Error(params.where(param), fmt::format("{}: {}", params.owner(), unknown_name("glass", *name, names)));
  }
  if (param == "eta") otherwise = number(params, "index", otherwise, least, 10);
  return number(params, param, otherwise, least, 10);
}

// A rough diffuse surface of version 3 ([OrenNayar1994]) has this share of the albedo of a smooth one: the mean of the model's
// A + B max(0, cos) sin tan over both directions.
float oren_nayar_albedo(float sigma_degrees) {
  const float sigma = sigma_degrees * (pi / 180), s2 = sigma * sigma;
  return 1 - s2 / (2 * (s2 + 0.33f)) + (2.0f / 3 - 64 / (45 * pi)) * 0.45f * s2 / (s2 + 0.09f);
}

Material PbrtReader::make_diffuse(const PbrtParams& params, std::string_view name, MaterialEntry& entry) {
  const float sigma = name == "Kd" ? number(params, "sigma", 0, 0, 90) : 0;
  if (sigma == 0) return Diffuse{textured_colour(params, name, Rgb(0.5f), entry)};
  approximate(params.where("sigma"), "'sigma' is not supported: only Lambertian surfaces are",
              "a Lambertian surface of the same albedo: it darkens towards the edge as rough ones do not");
  const float albedo = oren_nayar_albedo(sigma);
  return Diffuse{textured_colour(params, name, Rgb(0.5f), entry, [albedo](const Rgb& kd) { return albedo * kd; })};
}

Material PbrtReader::make_conductor(const PbrtParams& params, bool version3) {
  Conductor conductor;
  // pbrt-v3 integrates the index of its copper like any spectrum.
  const MetalIndex copper =
      version3 ? MetalIndex{"Cu", {0.200438f, 0.924033f, 1.102212f}, {3.912949f, 2.452848f, 2.142188f}} : metals()[3];
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
  glass.eta = refractive_index(params, 0.1f);
  // Version 3 takes glass without roughness as smooth before it remaps.
  bool rough = !version3_ && number(params, "roughness", 0, 0, 1) > 0;
  for (const char* name : {"uroughness", "vroughness"}) rough |= number(params, name, 0, 0, 1) > 0;
  const float alpha = isotropic_alpha(params, 0, true, RoughnessBy::axis);
  glass.alpha = rough ? smooth_where_even(alpha, glass.eta) : 0;
  return glass;
}

Material PbrtReader::make_dielectric(const PbrtParams& params) {
  Dielectric dielectric;
  dielectric.eta = refractive_index(params, 0.1f);
  dielectric.alpha = smooth_where_even(isotropic_alpha(params, 0, false), dielectric.eta);
  return dielectric;
}

Material PbrtReader::make_coated_diffuse(const PbrtParams& params, MaterialEntry& entry) {
  Plastic plastic;
  plastic.reflectance = textured_colour(params, "reflectance", Rgb(0.5f), entry);
  plastic.alpha = isotropic_alpha(params, 0, false);
  // In pbrt it holds a medium of extinction 1; by its `albedo`, 0 unless stated, light scatters on there.
  const Rgb albedo = colour(params, "albedo", Rgb(0), ColourUse::reflectance);
  if (!is_black(albedo))
    params.approximate("albedo", "nothing scatters inside the coat",
                       "a coat that absorbs the share that does not scatter, and lets the rest straight through");
  const float thickness = number(params, "thickness", 0.01f, 0, 1000);
  plastic.coat = {refractive_index(params, 1.0001f), thickness * (1 - mean_component(albedo))};
  warn(params.where(), params.owner() + ": light between coat and base is summed in closed form, not sampled");
  params.ignore({"g", "maxdepth", "nsamples"});  // of what scatters, or of pbrt's sampling
  return plastic;
}

// Version 3's "bumpmap" and version 4's "displacement" are heights, "normalmap" is an image's file. Of a mix, each has its own.
void PbrtReader::read_relief(const PbrtParams& params, MaterialEntry& entry) {
  if (const std::string file = params.string("normalmap", ""); !file.empty()) {
    const Location where = params.where("normalmap");
    RgbImage image = files_.image(file, where.file, where, Encoding::linear);
    warn_of_texels(image, where, file);
    if (extension_of(file) != ".png" && !holds_floats(files_.read(file, where.file, where).bytes))
      warn(where,
           fmt::format("the normals of '{}' are its values as they are; pbrt-v4 decodes them as sRGB, for it is no PNG", file));
    entry.relief = {Relief::Kind::normals, add_texture(ImageTexture{.size = image.size, .texels = std::move(image.texels)})};
  }
  const bool has_normals = entry.relief.kind == Relief::Kind::normals && params.has("normalmap");
  for (const std::string_view name : {"displacement", "bumpmap"}) {
    const auto texture = params.texture(name);
    if (texture && has_normals && !version3_) {
      warn(params.where(name), fmt::format("{}: '{}' has no effect beside 'normalmap', as in pbrt-v4", params.owner(), name));
      continue;
    }
    if (!texture) {
      params.number(name, 0);  // the same height all over
      continue;
    }
    TextureEntry& heights = find_texture(params, name, *texture, float_textures_);
    if (std::holds_alternative<Rgb>(heights.value)) continue;
    if (std::holds_alternative<Texture>(heights.value) &&
        std::holds_alternative<CheckerTexture>(std::get<Texture>(heights.value)))
      warn(params.where(name), "checks as relief are flat: their edges have no width");
    if (const Field* field = std::get_if<Field>(&heights.value)) {
      entry.relief = {Relief::Kind::heights, no_id, *field};
      continue;
    }
    if (!heights.relief) heights.relief = add_texture(texture_to_copy(heights));
    entry.relief = {Relief::Kind::heights, *heights.relief};
  }
}

PbrtReader::MaterialEntry PbrtReader::make_material(const std::string& type, const PbrtParams& params) {
  MaterialEntry entry;
  if (type.empty() || type == "interface" || type == "none") {
    entry.invisible = true;  // without media on its sides, nothing happens there
    params.ignore_all();
    return entry;
  }
  require_known("Material", "material", type, params.where());
  if (type == "mix") {
    entry = make_mix(params);
  } else if (type == "diffuse") {
    entry.material = make_diffuse(params, "reflectance", entry);
  } else if (type == "matte") {
    entry.material = make_diffuse(params, "Kd", entry);
  } else if (type == "mirror") {
    entry.material = make_mirror(params);
  } else if (type == "conductor" || type == "metal") {
    entry.material = make_conductor(params, type == "metal");
  } else if (type == "dielectric") {
    entry.material = make_dielectric(params);
  } else if (type == "glass") {
    entry.material = make_glass(params);
  } else if (type == "thindielectric") {
    entry.material = Dielectric{.eta = refractive_index(params, 0.1f), .thin = true};
  } else if (type == "coateddiffuse") {
    entry.material = make_coated_diffuse(params, entry);
  } else if (type == "plastic") {
    entry.material = make_plastic(params, entry);
  } else {
    make_nearest(type, params, entry);
  }
  read_relief(params, entry);
  params.finish();
  const auto* const metal = std::get_if<Conductor>(&entry.material);
  entry.textured |= metal && metal->is_anisotropic();  // its highlights turn with u
  return entry;
}

void PbrtReader::material(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Material");
  PbrtParams params(lexer, titled(token.text, type), where, version3_);
  params.add_defaults(attributes_.defaults["material"]);
  materials_.push_back(make_material(type, params));
  attributes_.material = static_cast<std::uint32_t>(materials_.size() - 1);
}

void PbrtReader::make_named_material(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "MakeNamedMaterial");
  PbrtParams params(lexer, titled(token.text, name), where, version3_);
  params.add_defaults(attributes_.defaults["material"]);
  if (!params.has("type")) params.fail("type", "is missing: the kind of material");
  materials_.push_back(make_material(params.string("type", ""), params));
  define(named_materials_, name, static_cast<std::uint32_t>(materials_.size() - 1), where, fmt::format("material '{}'", name));
}

void PbrtReader::named_material(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "NamedMaterial");
  const auto found = named_materials_.find(name);
  if (found == named_materials_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, entry] : named_materials_) names.push_back(known);
    throw Error(where, unknown_name("named material", name, names) + or_further_down());
  }
  attributes_.material = found->second;
}

std::uint32_t PbrtReader::scene_material(std::uint32_t index) {
  MaterialEntry& entry = materials_[index];
  if (!entry.scene_index) {
    entry.scene_index = static_cast<std::uint32_t>(scene_.materials.size());
    std::optional<Relief> relief;
    if (entry.relief) relief = Relief{.kind = entry.relief.kind, .texture = entry.relief.texture};
    add_material(entry.material, relief);
  }
  return *entry.scene_index;
}

std::uint32_t PbrtReader::add_material(const Material& material, const std::optional<Relief>& relief) {
  const auto index = static_cast<std::uint32_t>(scene_.materials.size());
  scene_.materials.push_back(material);
  if (relief) scene_.reliefs.push_back(*relief);
  if (relief) scene_.reliefs.back().material = index;
  return index;
}

}  // namespace etendue
