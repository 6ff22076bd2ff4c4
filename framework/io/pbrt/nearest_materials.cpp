// Materials of pbrt without an exact equal, as the nearest of diffuse, conductor, dielectric and plastic. What differs by more
// than how a coat and its base exchange light is an approximation, which the user has to allow.

#include "framework/core/elementary.h"
#include "framework/io/mixed_material.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

// Reduced scattering and absorption, 1/mm: [JensenMarschner2001] figure 5, and Coke.
constexpr float measured[12][6] = {
    {2.29f, 2.39f, 1.97f, 0.0030f, 0.0034f, 0.046f}, {0.15f, 0.21f, 0.38f, 0.015f, 0.077f, 0.19f},
    {0.19f, 0.25f, 0.32f, 0.018f, 0.088f, 0.20f},    {7.38f, 5.47f, 3.15f, 0.0002f, 0.0028f, 0.0163f},
    {0.18f, 0.07f, 0.03f, 0.061f, 0.97f, 1.45f},     {2.19f, 2.62f, 3.00f, 0.0021f, 0.0041f, 0.0071f},
    {0.68f, 0.70f, 0.55f, 0.0024f, 0.0090f, 0.12f},  {0.70f, 1.22f, 1.90f, 0.0014f, 0.0025f, 0.0142f},
    {0.74f, 0.88f, 1.01f, 0.032f, 0.17f, 0.48f},     {1.09f, 1.59f, 1.79f, 0.013f, 0.070f, 0.145f},
    {2.55f, 3.21f, 3.77f, 0.0011f, 0.0024f, 0.014f}, {8.9e-5f, 8.4e-5f, 0, 0.10014f, 0.16503f, 0.2468f}};
constexpr std::string_view measured_names[12] = {"Apple",  "Chicken1", "Chicken2", "Cream", "Ketchup",   "Marble",
                                                 "Potato", "Skimmilk", "Skin1",    "Skin2", "Wholemilk", "Coke"};

// Diffuse reflectance of a thick slab by the dipole ([JensenMarschner2001] eq. 15), A being that of eta 1.33.
Rgb dipole_reflectance(const Rgb& scattering, const Rgb& absorption) {
  constexpr float boundary = 2.8f;
  Rgb result;
  for (int c = 0; c < 3; ++c) {
    const float sum = scattering[c] + absorption[c], albedo = sum > 0 ? scattering[c] / sum : 0;
    const float root = std::sqrt(3 * (1 - albedo));
    result[c] = 0.5f * albedo * (1 + math::exp(-4.0f / 3 * boundary * root)) * math::exp(-root);
  }
  return result;
}

// The albedo under a coat that makes the base, seen straight on under even light, as bright as one of reflectance `bare`.
Rgb albedo_under(const Coat& coat, const Rgb& bare) {
  const float eta = coat.eta(), through = (1 - normal_reflectance(eta)) * (1 - fresnel_average(eta));
  const Rgb gain = bare * (eta * eta / through);
  return glm::clamp(gain / (1.0f + gain * coat.internal_reflectance()), Rgb(0), Rgb(1));
}

// The index of a surface that reflects this share of light from everywhere.
float index_of_average(float reflected) {
  if (reflected <= 1e-4f) return 1;
  float low = 1.001f, high = 20;
  for (int i = 0; i < 40; ++i) {
    const float middle = 0.5f * (low + high);
    (fresnel_average(middle) < reflected ? low : high) = middle;
  }
  return high;
}

Rgb metal_reflectance(const Conductor& metal) {
  if (metal.ideal) return metal.tint;
  const Rgb e1 = metal.eta - 1.0f, e2 = metal.eta + 1.0f, k2 = metal.k * metal.k;
  return metal.tint * (e1 * e1 + k2) / (e2 * e2 + k2);
}

// The metal that reflects so much straight on, as make_conductor chooses it.
Conductor metal_of(const Rgb& reflectance, const vec2& alpha) {
  const Rgb r = glm::clamp(reflectance, Rgb(1e-4f), Rgb(0.9999f));
  Conductor metal;
  metal.eta = Rgb(1);
  metal.k = 2.0f * glm::sqrt(r) / glm::sqrt(1.0f - r);
  metal.alpha = alpha;
  return metal;
}

}  // namespace

void PbrtReader::make_nearest(const std::string& type, const PbrtParams& params, MaterialEntry& entry) {
  const std::string what = fmt::format("material \"{}\" is not supported", type);
  if (type == "uber") {
    entry.material = make_uber(params, entry);
  } else if (type == "substrate") {
    entry.material = make_substrate(params, entry);
  } else if (type == "translucent" || type == "diffusetransmission") {
    entry.material = make_transmitting(params, type == "translucent", entry);
  } else if (type == "coatedconductor") {
    entry.material = make_coated_conductor(params);
  } else if (type == "disney") {
    entry.material = make_disney(params, entry);
  } else if (type == "subsurface" || type == "kdsubsurface") {
    approximate(params.where(), what, "a coated diffuse surface of the same albedo: light comes out where it went in");
    entry.material = make_subsurface(params, type == "kdsubsurface", entry);
  } else if (type == "hair") {
    approximate(params.where(), what, "a diffuse surface of its colour, without highlights");
    entry.material = make_hair(params, entry);
  } else {  // measured, fourier
    approximate(params.where(), what, "a diffuse surface of reflectance 0.5: neither colour nor highlights are the file's");
    params.ignore_all();
    entry.material = Diffuse{Rgb(0.5f)};
  }
}

float PbrtReader::specular_strength(const PbrtParams& params, std::string_view name, float otherwise) {
  const Rgb strength = colour(params, name, Rgb(otherwise), ColourUse::reflectance);
  if (max_component(strength) + max_component(-strength) > 1e-3f)  // the largest less the smallest
    approximate(params.where(name), fmt::format("a coloured '{}': coats reflect white", name),
                "its mean: highlights of coats have no colour");
  return mean_component(strength);
}

Material PbrtReader::make_coated(const PbrtParams& params, std::string_view base, const Rgb& otherwise, float eta, float alpha,
                                 MaterialEntry& entry) {
  if (eta == 1) return Diffuse{textured_colour(params, base, otherwise, entry)};
  warn(params.where(),
       params.owner() + ": is a diffuse base under a dielectric coat that conserves energy, not pbrt-v3's sum of two lobes");
  Plastic plastic;
  plastic.coat = eta;
  plastic.alpha = alpha;
  plastic.reflectance = textured_colour(params, base, otherwise, entry,
                                        [coat = plastic.coat](const Rgb& bare) { return albedo_under(coat, bare); });
  return plastic;
}

// pbrt-v3 computes the highlights of plastic as seen from within the coat, totally reflected beyond 42 degrees. The coat here
// reflects as much of light that comes evenly from everywhere: more than pbrt's straight on, less at the edge.
Material PbrtReader::make_plastic(const PbrtParams& params, MaterialEntry& entry) {
  const float reflected = specular_strength(params, "Ks", 0.25f) * Coat(1.5f).internal_reflectance();
  return make_coated(params, "Kd", Rgb(0.25f), index_of_average(reflected),
                     isotropic_alpha(params, 0.1f, true, RoughnessBy::one), entry);
}

// Version 3 adds a diffuse lobe, glossy and ideal reflection and ideal refraction.
Material PbrtReader::make_uber(const PbrtParams& params, MaterialEntry& entry) {
  const Rgb reflected = colour(params, "Kr", Rgb(0), ColourUse::reflectance);
  const Rgb refracted = colour(params, "Kt", Rgb(0), ColourUse::reflectance);
  const float eta = refractive_index(params, 1), strength = specular_strength(params, "Ks", 0.25f);
  const float alpha = isotropic_alpha(params, 0.1f, true);
  if (const auto name = params.texture("opacity")) {
    entry.opacity = field_operand(params, "opacity", Rgb(1), spectrum_textures_);
  } else {
    const Rgb opacity = colour(params, "opacity", Rgb(1), ColourUse::reflectance);
    entry.constant_opacity = mean_component(opacity);
    if (max_component(glm::abs(opacity - Rgb(entry.constant_opacity))) > 1e-5f)
      approximate(params.where("opacity"), "'opacity' of a colour: light of all colours passes alike",
                  "its mean: what shows through is not tinted");
    entry.invisible = entry.constant_opacity == 0;
  }
  if (!is_black(refracted)) {
    const bool pure = strength == 0 && params.has("Kd") && !params.texture("Kd") &&
                      is_black(colour(params, "Kd", Rgb(0.25f), ColourUse::reflectance));
    if (!pure)
      approximate(params.where("Kt"), "'Kt' beside Kd or Ks: a surface is either diffuse or refracts",
                  "glass of Kr and Kt: its diffuse part is missing");
    params.ignore({"Kd"});
    Dielectric glass;
    glass.eta = std::max(eta, 1.0001f);
    glass.reflect_tint = reflected;
    glass.transmit_tint = refracted;
    return glass;
  }
  if (eta < 1.0001f) return Diffuse{textured_colour(params, "Kd", Rgb(0.25f), entry)};  // nothing is reflected
  const float ideal = mean_component(reflected);
  if (ideal > 0 && strength > 0)
    approximate(params.where("Kr"), "'Kr' beside Ks: a coat is either smooth or rough",
                "the stronger of the two, as strong as both");
  return make_coated(params, "Kd", Rgb(0.25f), index_of_reflectance((strength + ideal) * normal_reflectance(eta)),
                     ideal > strength ? 0 : alpha, entry);
}

// Version 3's Fresnel blend ([Ashikhmin2000]) as a coat that reflects Ks straight on.
Material PbrtReader::make_substrate(const PbrtParams& params, MaterialEntry& entry) {
  const float strength = specular_strength(params, "Ks", 0.5f);
  return make_coated(params, "Kd", Rgb(0.5f), index_of_reflectance(strength),
                     isotropic_alpha(params, 0.1f, true, RoughnessBy::axis), entry);
}

// Takes the lobe with most weight: metal, rough glass, or the diffuse one under its dielectric coat.
Material PbrtReader::make_disney(const PbrtParams& params, MaterialEntry& entry) {
  const bool metallic = number(params, "metallic", 0, 0, 1) > 0.5f, glassy = number(params, "spectrans", 0, 0, 1) > 0.5f;
  const float eta = refractive_index(params, 1.0001f), alpha = std::max(square(number(params, "roughness", 0.5f, 0, 1)), 1e-3f);
  approximate(params.where(), "material \"disney\" is not supported",
              metallic ? "metal alone"
              : glassy ? "rough glass alone"
                       : "a diffuse base under a rough dielectric coat");
  const auto base = [&] { return colour(params, "color", Rgb(0.5f), ColourUse::reflectance); };
  Material material;
  if (metallic)
    material = metal_of(base(), vec2(alpha));
  else if (glassy)
    material = Dielectric{.eta = eta, .alpha = alpha, .transmit_tint = glm::sqrt(base())};
  else
    material = make_coated(params, "color", Rgb(0.5f), eta, alpha, entry);
  params.ignore_all();
  return material;
}

// Both materials keep shares of light on either side, which together are no more than all of it.
Material PbrtReader::make_transmitting(const PbrtParams& params, bool version3, MaterialEntry& entry) {
  if (version3) {
    const float strength = specular_strength(params, "Ks", 0.25f);
    if (strength > 0)
      approximate(params.where("Ks"), "'Ks' of material \"translucent\" is not supported", "0: it has no highlights");
    params.ignore({"roughness", "uroughness", "vroughness", "remaproughness"});
  }
  const float factor = version3 ? 1 : number(params, "scale", 1, 0, 1e6f);
  const std::string_view names[2] = {version3 ? "reflect" : "reflectance", version3 ? "transmit" : "transmittance"};
  const Rgb otherwise(version3 ? 0.5f : 0.25f);
  const auto share_of_kd = [&](std::string_view name) {
    return version3 ? colour(params, name, otherwise, ColourUse::reflectance) : Rgb(1);
  };
  const Rgb shares[2] = {share_of_kd(names[0]), share_of_kd(names[1])};
  const auto part = [&](int side, float scale) {
    if (version3)
      return textured_part(params, "Kd", Rgb(0.25f), entry,
                           [share = scale * shares[side]](const Rgb& kd) { return share * kd; });
    const ColourMap scaled = [scale](const Rgb& r) { return glm::min(scale * r, Rgb(1)); };
    return textured_part(params, names[side], otherwise, entry, scale == 1 ? ColourMap() : scaled);
  };
  DiffuseTransmission sheet{part(0, factor), part(1, factor)};
  if (const float most = most_of(sheet.reflectance) + most_of(sheet.transmittance); most > 1 + 1e-4f) {
    tell_of_excess(params, names[0]);
    sheet = {part(0, factor / most), part(1, factor / most)};
  }
  return sheet;
}

void PbrtReader::tell_of_excess(const PbrtParams& params, std::string_view name) {
  approximate(params.where(name), "a surface that reflects and lets through more than all light",
              "both scaled alike to no more than that");
}

// Images stay; all else that varies becomes its mean, for a surface bakes one texture alone.
TexturedRgb PbrtReader::textured_part(const PbrtParams& params, std::string_view name, const Rgb& otherwise,
                                      MaterialEntry& entry, const ColourMap& map) {
  MaterialEntry read;
  const TexturedRgb colour = textured_colour(params, name, otherwise, read, map);
  if (!read.field) {
    entry.textured |= read.textured;
    return colour;
  }
  approximate(params.where(name),
              fmt::format("'{}' is a texture that is no image, of a surface that light comes through", name), "its mean");
  return within_unit(mean_of(read.field));
}

float PbrtReader::most_of(const TexturedRgb& colour) const {
  if (colour.is_constant()) return max_component(colour.constant);
  float most = 0;
  const Texture& texture = scene_.textures[colour.texture];
  if (const auto* checks = std::get_if<CheckerTexture>(&texture))
    return std::max(max_component(checks->even), max_component(checks->odd));
  const auto& image = std::get<ImageTexture>(texture);
  for (const Rgb& texel : image.texels) most = std::max(most, image.gain * max_component(texel));
  return most;
}

// Takes what coat and metal reflect together straight on, their mutual reflections summed.
Material PbrtReader::make_coated_conductor(const PbrtParams& params) {
  approximate(params.where(), "material \"coatedconductor\" is not supported",
              "a conductor that reflects as much straight on, as rough as the rougher of the two layers");
  const float eta = refractive_index(params, 1.0001f, 1.5f, "interface.eta");
  const auto alpha_of = [&](const std::string& layer, float otherwise) {
    const float both = number(params, layer + ".roughness", otherwise, 0, 1);
    return vec2(number(params, layer + ".uroughness", both, 0, 1), number(params, layer + ".vroughness", both, 0, 1));
  };
  vec2 alpha = glm::max(alpha_of("interface", 0), alpha_of("conductor", 0));
  if (params.boolean("remaproughness", true)) alpha = glm::sqrt(alpha);
  alpha = std::max(alpha.x, alpha.y) < 1e-3f ? vec2(0) : glm::max(alpha, vec2(1e-4f));
  Rgb base = colour(params, "reflectance", Rgb(0), ColourUse::reflectance);
  if (!params.has("reflectance")) {
    Conductor metal;
    metal.eta = params.colour("conductor.eta", ColourUse::index).value_or(metals()[3].eta) / eta;
    metal.k = params.colour("conductor.k", ColourUse::index).value_or(metals()[3].k) / eta;
    base = metal_reflectance(metal);
  }
  const float coat = normal_reflectance(eta);
  params.ignore({"thickness", "g", "albedo", "maxdepth", "nsamples"});
  return metal_of(coat + square(1 - coat) * base / (1.0f - coat * base), alpha);
}

Material PbrtReader::make_subsurface(const PbrtParams& params, bool by_colour, MaterialEntry& entry) {
  Rgb scattering(2.55f, 3.21f, 3.77f), absorption(0.0011f, 0.0024f, 0.014f);  // pbrt's defaults
  const std::string name = params.string("name", "");
  if (const auto* known = std::find(std::begin(measured_names), std::end(measured_names), name);
      !name.empty() && known == std::end(measured_names))
    warn(params.where("name"), fmt::format("the scattering of {} is not known here: taken as that of milk", quote(name)));
  for (std::size_t i = 0; i < std::size(measured_names); ++i)
    if (name == measured_names[i]) {
      const float* const m = measured[i];
      scattering = {m[0], m[1], m[2]};
      absorption = {m[3], m[4], m[5]};
    }
  const auto coefficient = [&](const char* key, const Rgb& otherwise) {
    return params.texture(key) ? otherwise : params.colour(key, ColourUse::light).value_or(otherwise);
  };
  scattering = coefficient("sigma_prime_s", coefficient("sigma_s", scattering));
  absorption = coefficient("sigma_a", absorption);
  const std::string_view albedo = by_colour ? "Kd" : "reflectance";
  Plastic plastic;
  plastic.coat = refractive_index(params, 1.0001f, 1.33f);
  plastic.alpha = isotropic_alpha(params, 0, by_colour || version3_, RoughnessBy::axis);
  plastic.reflectance = textured_colour(params, albedo, by_colour ? Rgb(0.5f) : dipole_reflectance(scattering, absorption),
                                        entry, [coat = plastic.coat](const Rgb& bare) { return albedo_under(coat, bare); });
  params.ignore({"scale", "mfp", "g", "Kr", "Kt"});
  return plastic;
}

// Without a colour it is that of brown hair.
Material PbrtReader::make_hair(const PbrtParams& params, MaterialEntry& entry) {
  const std::string_view name = params.has("color") ? "color" : "reflectance";
  Diffuse hair{textured_colour(params, name, Rgb(0.12f, 0.07f, 0.04f), entry)};
  params.ignore_all();
  return hair;
}

const PbrtReader::MaterialEntry& PbrtReader::named_entry(const PbrtParams& params, std::string_view param,
                                                         const std::string& name) const {
  const auto found = named_materials_.find(name);
  if (found != named_materials_.end()) return materials_[found->second];
  std::vector<std::string> names;
  for (const auto& [known, entry] : named_materials_) names.push_back(known);
  throw Error(params.where(param), unknown_name("named material", name, names) + or_further_down());
}

bool PbrtReader::is_plain_surface(const MaterialEntry& entry) {
  return !entry.invisible && !entry.opacity && entry.constant_opacity == 1 && !entry.relief && !entry.field;
}

// The reflectance of a diffuse surface, wherever it is kept.
std::optional<Field> PbrtReader::diffuse_field(const MaterialEntry& entry) const {
  const auto* const diffuse = std::get_if<Diffuse>(&entry.material);
  if (!diffuse || entry.invisible || entry.opacity || entry.constant_opacity < 1 || entry.relief) return std::nullopt;
  if (entry.field) return entry.field;
  if (diffuse->reflectance.is_constant()) return constant_field(diffuse->reflectance.constant);
  return texture_field(scene_.textures[diffuse->reflectance.texture]);
}

// Version 3's amount is the share of the first material, version 4's that of the second.
PbrtReader::MaterialEntry PbrtReader::make_mix(const PbrtParams& params) {
  std::vector<std::string> names = params.strings("materials");
  const bool version4 = params.has("materials");
  if (!version4) names = {params.string("namedmaterial1", ""), params.string("namedmaterial2", "")};
  const std::string_view param = version4 ? "materials" : "namedmaterial1";
  if (names.size() != 2) params.fail(param, fmt::format("has {} names; expected two", names.size()));
  const MaterialEntry &a = named_entry(params, param, names[0]), &b = named_entry(params, param, names[1]);
  TextureMap& textures = version4 ? float_textures_ : spectrum_textures_;
  const Field amount = field_operand(params, "amount", Rgb(0.5f), textures);
  const auto field_a = diffuse_field(a), field_b = diffuse_field(b);
  if (field_a && field_b) {
    const Field mixed =
        combined_field(params, {amount, *field_a, *field_b}, [version4](const TexturePlace& place, std::span<const Field> f) {
          const Rgb share = within_unit(f[0]->at(place)), first = version4 ? 1.0f - share : share;
          return first * f[1]->at(place) + (1.0f - first) * f[2]->at(place);
        });
    MaterialEntry entry{.material = Diffuse{Rgb(0.5f)}, .textured = true, .field = mixed, .scene_index = {}};
    if (!a.textured && !b.textured && !params.texture("amount"))
      entry = {.material = Diffuse{mixed->at({})}, .scene_index = {}};
    return entry;
  }
  const Rgb amounts = within_unit(mean_of(amount)), shares = version4 ? amounts : 1.0f - amounts;  // of the second
  const bool is_plain = !params.texture("amount") && is_plain_surface(a) && is_plain_surface(b);
  if (const auto both = is_plain ? mixed(a.material, b.material, shares) : std::nullopt) {
    MaterialEntry entry = a;
    entry.material = *both;
    entry.scene_index.reset();
    return entry;
  }
  const float first = 1 - mean_component(shares);
  const MaterialEntry& heavier = first > 0.5f ? a : b;
  if (std::max(first, 1 - first) < 0.999f || params.texture("amount"))
    approximate(params.where(),
                "material \"mix\" is not supported but of surfaces that are diffuse, or alike but for constant colours",
                "the material with the larger share, alone");
  MaterialEntry entry = heavier;
  entry.scene_index.reset();
  return entry;
}

}  // namespace etendue
