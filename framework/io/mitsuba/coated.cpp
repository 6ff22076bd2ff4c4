// BSDFs of a diffuse base and a glossy lobe, and those of many lobes, for which one material must stand.

#include "framework/io/mitsuba/reader.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

MitsubaReader::MaterialEntry MitsubaReader::plastic(const Properties& of) {
  const bool rough = of.type() != "plastic";
  if (of.type() == "pplastic")
    approximate(of.where(), fmt::format("{} is not supported", of.title()), "roughplastic: light is not polarized");
  MaterialEntry entry;
  Plastic coated;
  const float eta = relative_index(of, "polypropylene");
  if (eta < 1) of.fail("int_ior", "is below 'ext_ior'; expected a coat that is denser than what surrounds it");
  coated.coat = eta;
  const Roughness facets = isotropic_roughness(of, rough, 0.1f);
  coated.alpha = facets.alpha.x;
  coated.distribution = facets.distribution;
  if (colour(of, "specular_reflectance", Rgb(1), ColourUse::reflectance) != Rgb(1))
    approximate(of.where("specular_reflectance"), fmt::format("{}: 'specular_reflectance' is not 1", of.title()),
                "1: a plain dielectric coat");
  if (coated.alpha > 0) warn(of.where(), fmt::format("{}: the rough coat transmits what a smooth one would", of.title()));
  // Without `nonlinear`, light that is reflected inside leaves the base with the colour of one reflection.
  const float inside = of.boolean("nonlinear", false) ? 0 : coated.coat.internal_reflectance();
  coated.reflectance = reflectance(of, "diffuse_reflectance", Rgb(0.5f), entry.textured, inside);
  entry.material = coated;
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::diffuse_and_lobe(const Properties& of, float alpha) {
  MaterialEntry entry;
  const Rgb lobe = colour(of, "specular_reflectance", Rgb(0.2f), ColourUse::reflectance);
  Plastic coated;
  coated.reflectance = reflectance(of, "diffuse_reflectance", Rgb(0.5f), entry.textured);
  coated.alpha = alpha;
  const bool is_metal = coated.reflectance.is_constant() && mean_component(lobe) > mean_component(coated.reflectance.constant);
  approximate(of.where(), fmt::format("{} is not supported", of.title()),
              is_metal ? "its glossy lobe alone, by GGX"
                       : "a diffuse base under a rough dielectric coat, whatever its glossy lobe reflects");
  if (is_metal)
    entry.material = Conductor{.tint = lobe, .ideal = true, .alpha = vec2(alpha)};
  else
    entry.material = coated;
  return entry;
}

// The alpha at which GGX is as wide, [Walter2007].
MitsubaReader::MaterialEntry MitsubaReader::phong(const Properties& of) {
  return diffuse_and_lobe(of, std::sqrt(2 / (number(of, "exponent", 30, 0, 1e8f) + 2)));
}

MitsubaReader::MaterialEntry MitsubaReader::ward(const Properties& of) {
  const float both = number(of, "alpha", 0.1f, 1e-3f, 10);
  of.ignore({"variant"});
  return diffuse_and_lobe(of, 0.5f * (number(of, "alpha_u", both, 1e-3f, 10) + number(of, "alpha_v", both, 1e-3f, 10)));
}

MitsubaReader::MaterialEntry MitsubaReader::principled(const Properties& of) {
  MaterialEntry entry{.two_sided = true};
  const float metallic = number(of, "metallic", 0, 0, 1), glassy = number(of, "spec_trans", 0, 0, 1);
  const float alpha = std::max(square(number(of, "roughness", 0.5f, 0, 1)), 1e-3f);
  const float specular = number(of, "specular", 0.5f, 0, 1);  // states the index in another way
  const float eta = std::max(number(of, "eta", 2 / (1 - std::sqrt(0.08f * specular)) - 1, 1, 3), 1.001f);
  const TexturedRgb base = reflectance(of, "base_color", Rgb(0.5f), entry.textured);
  if (metallic > 0.5f || glassy > 0.5f) entry.textured = false;
  if (metallic > 0.5f) {
    const Rgb r = glm::min(base.is_constant() ? base.constant : colour(of, "base_color", Rgb(0.5f), ColourUse::reflectance),
                           Rgb(0.9999f));
    entry.material = Conductor{.eta = Rgb(1), .k = 2.0f * glm::sqrt(r) / glm::sqrt(1.0f - r), .alpha = vec2(alpha)};
  } else if (glassy > 0.5f) {
    entry.material =
        Dielectric{.eta = eta, .alpha = alpha, .transmit_tint = base.is_constant() ? glm::sqrt(base.constant) : Rgb(1)};
  } else {
    entry.material = Plastic{base, eta, alpha};
  }
  approximate(of.where(), fmt::format("{} is not supported", of.title()),
              metallic > 0.5f ? "metal alone"
              : glassy > 0.5f ? "rough glass alone"
                              : "a diffuse base under a rough dielectric coat");
  of.ignore_all();
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::polarizer(const Properties& of) {
  of.ignore_all();
  approximate(of.where(), fmt::format("{} is not supported: light is not polarized", of.title()), "no surface");
  return {.two_sided = true, .invisible = true};
}

MitsubaReader::MaterialEntry MitsubaReader::diffuse_transmitter(const Properties& of) {
  MaterialEntry entry{.two_sided = true};
  entry.material = DiffuseTransmission{Rgb(0), reflectance(of, "transmittance", Rgb(0.5f), entry.textured)};
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::other_bsdf(const Properties& of) {
  of.ignore_all();
  approximate(of.where(), fmt::format("{} is not supported", of.title()), "grey diffuse of 0.5");
  return {.two_sided = true};
}

}  // namespace etendue
