// BSDFs by Mitsuba's names. Roughness is alpha as it stands; alphas below 0.001 are perfectly smooth. Beckmann's distribution
// is Mitsuba's default.

#include "framework/core/lists.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace etendue {

namespace {

struct NamedIndex {
  std::string_view name;
  float eta;
};

// At 589 nm and 20 degrees, as Mitsuba's documentation lists them.
constexpr NamedIndex indices[] = {
    {"vacuum", 1.0f},      {"helium", 1.00004f},         {"hydrogen", 1.00013f},
    {"air", 1.00028f},     {"carbon dioxide", 1.00045f}, {"water", 1.3330f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.470f},     {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.5750f},      {"diamond", 2.419f},
};

// Metals that Mitsuba alone names, fitted as those of framework/io/spectra.h are. Spectral data: Cr, Ni and TiN [Palik1998],
// W [Weaver1975].
constexpr MetalIndex metals_of_mitsuba[] = {
    {"Cr", {3.6763f, 3.0843f, 1.8672f}, {4.2908f, 4.4519f, 4.1310f}},
    {"Ni", {1.9872f, 1.7564f, 1.6210f}, {3.7890f, 3.2198f, 2.6079f}},
    {"TiN", {1.4083f, 1.2088f, 1.4907f}, {2.9471f, 2.0290f, 1.2516f}},
    {"W", {3.6351f, 3.4826f, 3.3006f}, {2.9158f, 2.7477f, 2.5099f}},
};

// Metals of which there is no index here, by their reflectance at normal incidence.
struct NamedReflectance {
  std::string_view name;
  Rgb reflectance;
};
constexpr Rgb grey_metal{0.55f};
const NamedReflectance other_metals[] = {
    {"Hg", {0.78f, 0.78f, 0.77f}},
    {"Na_palik", {0.97f, 0.96f, 0.92f}},
    {"Rh", {0.77f, 0.75f, 0.73f}},
    {"a-C", grey_metal},
    {"AlAs", grey_metal},
    {"AlSb", grey_metal},
    {"Be", grey_metal},
    {"CsI", grey_metal},
    {"Cu2O", grey_metal},
    {"CuO", grey_metal},
    {"d-C", grey_metal},
    {"HgTe", grey_metal},
    {"Ir", grey_metal},
    {"K", grey_metal},
    {"Li", grey_metal},
    {"Mo", grey_metal},
    {"Nb", grey_metal},
    {"Se", grey_metal},
    {"SiC", grey_metal},
    {"SnTe", grey_metal},
    {"Ta", grey_metal},
    {"Te", grey_metal},
    {"ThF4", grey_metal},
    {"TiC", grey_metal},
    {"VC", grey_metal},
    {"V_palik", grey_metal},
    {"VN", grey_metal},
};

bool is_smooth(std::string_view type) {
  return type == "diffuse" || type == "conductor" || type == "dielectric" || type == "thindielectric" || type == "plastic";
}

}  // namespace

std::span<const MitsubaReader::BsdfType> MitsubaReader::bsdf_types() {
  using R = MitsubaReader;
  static constexpr BsdfType table[] = {
      {"diffuse", "as it is", &R::diffuse},
      {"dielectric", "as it is; int_ior and ext_ior by number or name", &R::dielectric},
      {"roughdielectric", "ggx or beckmann; others approximated by beckmann, two alphas by their mean", &R::dielectric},
      {"conductor", "material, or eta and k; ext_eta", &R::conductor},
      {"roughconductor",
       "ggx or beckmann, with alpha or alpha_u, alpha_v; others approximated by beckmann; brushed along the edges of meshes "
       "without texture coordinates",
       &R::conductor},
      {"plastic", "as it is, nonlinear or not; another specular_reflectance than 1 approximated by 1", &R::plastic},
      {"roughplastic", "the same with a rough coat, which keeps the smooth one's transmission", &R::plastic},
      {"pplastic", "approximated by roughplastic: light is not polarized", &R::plastic},
      {"twosided", "the bsdf in it; of two different ones approximated by the first", &R::two_sided},
      {"null", "no surface; of a light, one that emits and lets all rays through", &R::null_bsdf},
      {"mask",
       "as it is, any ray passes by the share that is not opaque; of an image its luminance; before version 2 an opacity that "
       "differs between colours approximated: its mean; an image's alpha channel approximated for its colours",
       &R::mask},
      {"blendbsdf",
       "two that are alike but for constant colours mixed, one and null as a mask; others approximated by the one with more "
       "weight",
       &R::blend},
      {"mixturebsdf", "like blendbsdf, where the weights add up to 1; others approximated by the one with most weight",
       &R::mixture},
      {"bumpmap",
       "as it is; heights of a coloured image are its luminance; of meshes without texture coordinates "
       "approximated by the bsdf in it",
       &R::bump},
      {"normalmap", "like bumpmap", &R::bump},
      {"roughdiffuse", "alpha 0 as it is; others approximated by diffuse", &R::rough_diffuse},
      {"thindielectric", "as it is; int_ior and ext_ior by number or name", &R::thin_dielectric},
      {"coating", "approximated: of a diffuse bsdf plastic, else the bsdf in it", &R::coating},
      {"roughcoating", "approximated: of a diffuse bsdf roughplastic, else the bsdf in it", &R::coating},
      {"phong", "approximated by a metallic GGX lobe or by roughplastic, whichever of the two lobes is larger", &R::phong},
      {"ward", "approximated like phong", &R::ward},
      {"principled", "approximated: metal, glass or roughplastic, whichever has most weight", &R::principled},
      {"principledthin", "approximated like principled", &R::principled},
      {"difftrans", "as it is", &R::diffuse_transmitter},
      {"hair", "approximated: grey diffuse of 0.5", &R::other_bsdf},
      {"hk", "approximated: grey diffuse of 0.5", &R::other_bsdf},
      {"irawan", "approximated: grey diffuse of 0.5", &R::other_bsdf},
      {"measured", "approximated: grey diffuse of 0.5", &R::other_bsdf},
      {"measured_polarized", "approximated: grey diffuse of 0.5", &R::other_bsdf},
      {"circular", "approximated: no surface", &R::polarizer},
      {"polarizer", "approximated: no surface", &R::polarizer},
      {"retarder", "approximated: no surface", &R::polarizer},
  };
  return table;
}

std::uint32_t MitsubaReader::bsdf(const XmlElement& element) {
  const auto [entry, is_new] = bsdfs_.try_emplace(&element);
  if (!is_new && !entry->second) throw Error(element.where(), "bsdf: refers to itself");
  if (is_new) {
    const Nesting nesting(*this, element);
    const Properties of = properties(element);
    const bool before = std::exchange(conserves_energy_, !version0() || of.boolean("ensure_energy_conservation", true));
    MaterialEntry made = (this->*find_type(bsdf_types(), of).handler)(of);
    conserves_energy_ = before;
    if (version0() && is_smooth(of.type()))
      have_no_effect(of, {"alpha", "alpha_u", "alpha_v", "distribution"}, "as in Mitsuba: only rough bsdfs have it");
    of.finish();
    materials_.push_back(std::move(made));
    bsdfs_[&element] = static_cast<std::uint32_t>(materials_.size() - 1);
  }
  return *bsdfs_[&element];
}

MitsubaReader::MaterialEntry& MitsubaReader::nested_bsdf(const Properties& of, std::size_t most) {
  const auto found = of.objects({"bsdf"});
  if (found.empty() || found.size() > most)
    throw Error(of.where(),
                fmt::format("{}: has {} bsdfs in it; expected {}", of.title(), found.size(), most == 1 ? "one" : "one or two"));
  if (found.size() > 1 && found[0] != found[1])
    approximate(found[1]->where(), fmt::format("{}: has another bsdf for its back", of.title()), "the first on both sides");
  return materials_[bsdf(*found[0])];
}

std::uint32_t MitsubaReader::material_of(const Properties& shape) {
  const auto found = shape.objects({"bsdf"});
  if (found.size() > 1)
    throw Error(found[1]->where(), fmt::format("{}: has {} bsdfs; expected one", shape.title(), found.size()));
  return found.empty() ? default_material(shape) : bsdf(*found[0]);
}

// Without a bsdf a light absorbs all that meets it, and before version 2 the boundary of a medium lets all pass; any other
// shape is diffuse.
std::uint32_t MitsubaReader::default_material(const Properties& shape) {
  MaterialEntry& entry = materials_.emplace_back();
  if (shape.has_object({"emitter", "luminaire"}))
    entry = {.material = Diffuse{Rgb(0)}, .two_sided = true};
  else if (version0() && shape.has_object({"medium"}))
    entry = {.two_sided = true, .invisible = true};
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

std::uint32_t MitsubaReader::scene_material(MaterialEntry& entry) {
  if (!entry.scene_index) {
    entry.scene_index = static_cast<std::uint32_t>(scene_.materials.size());
    scene_.materials.push_back(entry.material);
    if (entry.relief) {
      scene_.reliefs.push_back(*entry.relief);
      scene_.reliefs.back().material = *entry.scene_index;
    }
  }
  return *entry.scene_index;
}

MitsubaReader::MaterialEntry MitsubaReader::diffuse(const Properties& of) {
  MaterialEntry entry;
  // Before version 2 the name may be that of other bsdfs.
  const bool by_other_name = version0() && of.has("diffuse_reflectance") && !of.has("reflectance");
  entry.material = Diffuse{reflectance(of, by_other_name ? "diffuse_reflectance" : "reflectance", Rgb(0.5f), entry.textured)};
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::rough_diffuse(const Properties& of) {
  if (number(of, "alpha", 0.2f, 0, 1) != 0)
    approximate(of.where(), fmt::format("{}: 'alpha' is not 0", of.title()), "a Lambertian surface");
  of.ignore({"use_fast_approx"});
  return diffuse(of);
}

float MitsubaReader::refractive_index(const Properties& of, std::string_view name, const std::string& otherwise) {
  const XmlElement* element = of.element(name);
  if (element && element->tag != "string") return number(of, name, 1.5f, 0.1f, 10);
  const std::string wanted = of.string(name, otherwise);
  const std::string lower_case = in_lower_case(wanted);
  std::vector<std::string> names;
  for (const NamedIndex& index : indices) {
    if (index.name == lower_case) return index.eta;
    names.emplace_back(index.name);
  }
  throw Error(of.where(name), fmt::format("{}: {}", of.title(), unknown_name("material", wanted, names)));
}

// Next to 1 there is no half vector of refraction.
float MitsubaReader::relative_index(const Properties& of, const std::string& inside) {
  const float eta = of.has("eta") && of.element("eta")->tag == "float"
                        ? of.number("eta", 1.5f, 0.1f, 10)
                        : refractive_index(of, "int_ior", inside) / refractive_index(of, "ext_ior", "air");
  return std::abs(eta - 1) < 1e-3f ? 1.001f : eta;
}

MitsubaReader::Roughness MitsubaReader::roughness(const Properties& of, bool rough, float otherwise) {
  if (!rough) return {};
  const float both = number(of, "alpha", otherwise, 0, 10);
  const vec2 alpha(number(of, "alpha_u", both, 0, 10), number(of, "alpha_v", both, 0, 10));
  of.ignore({"sample_visible"});
  const std::string distribution = in_lower_case(of.string("distribution", "beckmann"));
  if (distribution != "beckmann" && distribution != "ggx" && distribution != "phong" && distribution != "as")
    throw Error(
        of.where("distribution"),
        fmt::format("{}: {}", of.title(),
                    unknown_name("distribution", distribution, std::vector<std::string>{"ggx", "beckmann", "phong", "as"})));
  if (std::max(alpha.x, alpha.y) < 1e-3f) return {};
  if (distribution == "phong" || distribution == "as")
    approximate(of.where("distribution"),
                fmt::format("{}: the distribution is '{}'; expected ggx or beckmann", of.title(), distribution),
                "Beckmann's with the same alpha");
  return {glm::max(alpha, vec2(1e-4f)), distribution == "ggx" ? NormalDistribution::ggx : NormalDistribution::beckmann};
}

MitsubaReader::Roughness MitsubaReader::isotropic_roughness(const Properties& of, bool rough, float otherwise) {
  Roughness found = roughness(of, rough, otherwise);
  if (found.alpha.x != found.alpha.y)
    approximate(of.where("alpha_u"),
                fmt::format("{}: 'alpha_u' differs from 'alpha_v'; only conductors may be anisotropic", of.title()),
                "the mean of both");
  found.alpha = vec2(0.5f * (found.alpha.x + found.alpha.y));
  return found;
}

MitsubaReader::MaterialEntry MitsubaReader::dielectric(const Properties& of) {
  Dielectric glass;
  glass.eta = relative_index(of, "bk7");
  const Roughness rough = isotropic_roughness(of, of.type() == "roughdielectric", 0.1f);
  glass.alpha = rough.alpha.x;
  glass.distribution = rough.distribution;
  glass.reflect_tint = colour(of, "specular_reflectance", Rgb(1), ColourUse::reflectance);
  glass.transmit_tint = colour(of, "specular_transmittance", Rgb(1), ColourUse::reflectance);
  return {.material = glass, .two_sided = true};
}

MitsubaReader::MaterialEntry MitsubaReader::thin_dielectric(const Properties& of) {
  Dielectric pane{.eta = relative_index(of, "bk7"), .thin = true};
  pane.reflect_tint = colour(of, "specular_reflectance", Rgb(1), ColourUse::reflectance);
  pane.transmit_tint = colour(of, "specular_transmittance", Rgb(1), ColourUse::reflectance);
  return {.material = pane, .two_sided = true};
}

void MitsubaReader::index_of_metal(const Properties& of, Conductor& metal) {
  const float outside = refractive_index(of, "ext_eta", version0() ? "air" : "vacuum");
  const bool has_eta = of.has("eta"), has_k = of.has("k");
  if (!has_eta && !has_k) return named_metal(of, outside, metal);
  metal.eta = Rgb(0);
  metal.k = Rgb(1) / outside;
  // What is not stated is the named metal's before version 2.
  if (!version0() && in_lower_case(of.string("material", "none")) != "none")
    of.fail("material", "stands beside 'eta' or 'k'; expected the one or the other");
  if (version0() && !(has_eta && has_k)) named_metal(of, outside, metal);
  if (has_eta) metal.eta = colour(of, "eta", Rgb(0), ColourUse::index) / outside;
  if (has_k) metal.k = colour(of, "k", Rgb(1), ColourUse::index) / outside;
  of.ignore({"material"});
  metal.ideal = is_black(metal.eta) && metal.k == Rgb(1) / outside;
  for (int c = 0; c < 3; ++c)
    if (metal.eta[c] == 0 && metal.k[c] == 0) of.fail("eta", "and 'k' are both 0 in a channel");
}

// Versions 2 and 3 have a mirror where nothing is said, earlier ones copper.
void MitsubaReader::named_metal(const Properties& of, float outside, Conductor& metal) {
  const std::string name = of.string("material", version0() ? "Cu" : "none");
  metal.ideal = in_lower_case(name) == "none";
  if (metal.ideal) return;
  // Most are there by another measurement as well.
  const std::string plain = name.ends_with("_palik") ? name.substr(0, name.size() - 6) : name;
  std::vector<std::string> names{"none"};
  for (const std::span<const MetalIndex> table : {metals(), std::span<const MetalIndex>(metals_of_mitsuba)})
    for (const MetalIndex& known : table) {
      if (plain == known.name) {
        metal.eta = known.eta / outside;
        metal.k = known.k / outside;
        return;
      }
      names.emplace_back(known.name);
    }
  for (const NamedReflectance& other : other_metals)
    if (name == other.name || plain == other.name) {
      approximate(of.where("material"), fmt::format("{}: there is no index of '{}' here", of.title(), name),
                  fmt::format("a metal that reflects {:.2f} {:.2f} {:.2f}", other.reflectance.x, other.reflectance.y,
                              other.reflectance.z));
      metal.eta = Rgb(1);
      metal.k = 2.0f * glm::sqrt(other.reflectance) / glm::sqrt(1.0f - other.reflectance);
      return;
    }
  throw Error(of.where("material"), fmt::format("{}: {}", of.title(), unknown_name("metal", name, names)));
}

MitsubaReader::MaterialEntry MitsubaReader::conductor(const Properties& of) {
  Conductor metal;
  index_of_metal(of, metal);
  const Roughness rough = roughness(of, of.type() == "roughconductor", 0.1f);
  metal.alpha = rough.alpha;
  metal.distribution = rough.distribution;
  metal.tint = colour(of, "specular_reflectance", Rgb(1), ColourUse::reflectance);
  return {.material = metal, .textured = metal.is_anisotropic()};
}

}  // namespace etendue
