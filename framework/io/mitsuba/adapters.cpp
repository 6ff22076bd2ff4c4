// BSDFs that change or mix others: two sides, opacity, relief, coats, mixtures.

#include "framework/io/mitsuba/reader.h"
#include "framework/io/mixed_material.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace etendue {

namespace {

float unevenness(const Rgb& colour) { return max_component(colour) - std::min({colour.x, colour.y, colour.z}); }

// How far the channels of an opacity differ.
float unevenness(const Texture& opacity) {
  if (const auto* checks = std::get_if<CheckerTexture>(&opacity))
    return std::max(unevenness(checks->even), unevenness(checks->odd));
  const auto& image = std::get<ImageTexture>(opacity);
  float most = 0;
  for (const Rgb& texel : image.texels) most = std::max(most, unevenness(image.gain * texel));
  return most;
}

// From version 2 on Mitsuba takes the luminance of images, and the mean of a constant colour, as a mask does.
Texture as_scalar(Texture opacity) {
  if (auto* image = std::get_if<ImageTexture>(&opacity))
    for (Rgb& texel : image->texels)
      if (unevenness(texel) > 0) texel = Rgb(luminance(texel));
  return opacity;
}

// From version 2 on Mitsuba's checkerboard has its colours in each other's places where it is asked for a number.
Texture as_opacity(Texture opacity) {
  if (auto* checks = std::get_if<CheckerTexture>(&opacity)) std::swap(checks->even, checks->odd);
  return as_scalar(std::move(opacity));
}

}  // namespace

MitsubaReader::MaterialEntry MitsubaReader::two_sided(const Properties& of) {
  MaterialEntry entry = nested_bsdf(of, 2);
  entry.two_sided = true;
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::null_bsdf(const Properties&) { return {.two_sided = true, .invisible = true}; }

MitsubaReader::MaterialEntry MitsubaReader::mask(const Properties& of) {
  MaterialEntry entry = nested_bsdf(of);
  const XmlElement* element = of.element("opacity");
  const TextureValue value = element ? opacity(*element) : Rgb(0.5f);
  set_mask(of, value, entry);
  return entry;
}

void MitsubaReader::set_mask(const Properties& of, const TextureValue& opacity, MaterialEntry& entry) {
  const auto* const varying = std::get_if<Texture>(&opacity);
  const float constant = varying ? 0.5f : mean_component(std::get<Rgb>(opacity));
  constexpr float visible = 0.02f;  // beyond the noise of JPEG
  if (version0() && (varying ? unevenness(*varying) : unevenness(std::get<Rgb>(opacity))) > visible)
    approximate(of.where(), fmt::format("{}: an opacity that differs between colours is not supported", of.title()),
                "the mean of its channels: what passes keeps its colour");
  entry.invisible = entry.invisible || constant <= 0;
  if (constant <= 0 || constant >= 1) return;
  if (entry.mask != no_id)
    approximate(of.where(), fmt::format("{}: a mask on a surface that has one already is not supported", of.title()),
                "the outer one alone");
  entry.mask = add_texture(varying ? version0() ? *varying : as_opacity(*varying)
                                   : ImageTexture{.size = {1, 1}, .texels = {Rgb(constant)}});
  entry.textured = entry.textured || varying;
  entry.scene_index.reset();
}

// Relief on a surface that has one is left as the outer one alone.
void MitsubaReader::read_relief(const XmlElement& element, Relief::Kind kind, float scale, MaterialEntry& entry) {
  if (is_colour(element)) {
    if (kind == Relief::Kind::normals)
      approximate(element.where(), "a normal map of one colour is not supported", "the smooth surface");
    return;
  }
  const TextureValue value = texture(element);
  const auto* const map = std::get_if<Texture>(&value);
  if (!map) return;
  if (std::holds_alternative<CheckerTexture>(*map) && kind == Relief::Kind::heights)
    warn(element.where(), "checks as relief are flat: their edges have no width");
  if (entry.relief)
    approximate(element.where(), "relief on a surface that has one already is not supported", "the outer one alone");
  const bool has_heights = kind == Relief::Kind::heights;
  entry.relief = Relief{.kind = kind, .texture = add_texture(has_heights ? as_scalar(*map) : *map), .scale = scale};
  entry.scene_index.reset();
}

MitsubaReader::MaterialEntry MitsubaReader::bump(const Properties& of) {
  MaterialEntry entry = nested_bsdf(of);
  const bool is_normals = of.type() == "normalmap";
  if (version0()) have_no_effect(of, {"scale"}, "as in Mitsuba 0.x: a scale texture has it");
  const float scale = is_normals || version0() ? 1 : number(of, "scale", 1, -1e6f, 1e6f);
  const auto maps = of.objects({"texture"});
  if (maps.size() != 1)
    throw Error(of.where(), fmt::format("{}: has {} textures in it; expected one", of.title(), maps.size()));
  read_relief(*maps[0], is_normals ? Relief::Kind::normals : Relief::Kind::heights, scale, entry);
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::coating(const Properties& of) {
  MaterialEntry entry = nested_bsdf(of);
  const auto* base = std::get_if<Diffuse>(&entry.material);
  approximate(of.where(), fmt::format("{} is not supported", of.title()),
              base ? "plastic, whose coat absorbs nothing" : "the surface without its coat");
  if (base) {
    const Roughness rough = isotropic_roughness(of, of.type() == "roughcoating", 0.1f);
    entry.material = Plastic{base->reflectance, std::max(relative_index(of, "bk7"), 1.001f), rough.alpha.x, rough.distribution};
  }
  entry.scene_index.reset();
  of.ignore_all();
  return entry;
}

MitsubaReader::MaterialEntry MitsubaReader::blend(const Properties& of) {
  const float weight = number(of, "weight", 0.5f, 0, 1);  // of the second
  const auto found = of.objects({"bsdf"});
  if (found.size() != 2) throw Error(of.where(), fmt::format("{}: has {} bsdfs in it; expected two", of.title(), found.size()));
  MaterialEntry first = materials_[bsdf(*found[0])], second = materials_[bsdf(*found[1])];
  first.scene_index.reset();
  second.scene_index.reset();
  if (first.invisible != second.invisible) {  // light passes by the share of that which is no surface
    MaterialEntry& seen = first.invisible ? second : first;
    set_mask(of, Rgb(first.invisible ? weight : 1 - weight), seen);
    return seen;
  }
  if (weight == 0 || weight == 1) return weight == 1 ? second : first;
  if (const auto both = mixed_entry(first, second, weight)) return *both;
  approximate(of.where(), fmt::format("{}: only bsdfs that are alike but for constant colours can be mixed", of.title()),
              "the bsdf with more weight alone");
  return weight > 0.5f ? second : first;
}

std::optional<MitsubaReader::MaterialEntry> MitsubaReader::mixed_entry(const MaterialEntry& a, const MaterialEntry& b,
                                                                       float share) {
  if (a.relief || b.relief || a.mask != b.mask || a.two_sided != b.two_sided) return std::nullopt;
  if (a.invisible && b.invisible) return a;
  const auto material = mixed(a.material, b.material, Rgb(share));
  if (a.invisible || b.invisible || !material) return std::nullopt;
  MaterialEntry both = a;
  both.material = *material;
  both.scene_index.reset();
  return both;
}

// Weights that do not add up to one absorb or make light.
MitsubaReader::MaterialEntry MitsubaReader::mixture(const Properties& of) {
  const auto found = of.objects({"bsdf"});
  if (found.empty()) throw Error(of.where(), fmt::format("{}: has no bsdfs in it", of.title()));
  std::string text = of.string("weights", "");
  std::replace(text.begin(), text.end(), ',', ' ');
  WordReader words(text);
  std::vector<float> weights;
  for (std::size_t i = 0; i < found.size(); ++i)
    weights.push_back(static_cast<float>(parse_number(words.word_on_any_line()).value_or(0)));
  std::optional<MaterialEntry> all = materials_[bsdf(*found[0])];
  float sum = weights[0];
  for (std::size_t i = 1; i < found.size(); ++i) {
    const MaterialEntry& next = materials_[bsdf(*found[i])];
    sum += weights[i];
    if (all && weights[i] != 0) all = weights[i] == sum ? next : mixed_entry(*all, next, weights[i] / sum);
  }
  if (all && std::abs(sum - 1) < 1e-3f && *std::ranges::min_element(weights) >= 0) {
    all->scene_index.reset();
    return *all;
  }
  approximate(of.where(), fmt::format("{}: only bsdfs that are alike but for constant colours can be mixed", of.title()),
              "the bsdf with most weight alone");
  const auto most = static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  MaterialEntry entry = materials_[bsdf(*found[most])];
  entry.scene_index.reset();
  return entry;
}

}  // namespace etendue
