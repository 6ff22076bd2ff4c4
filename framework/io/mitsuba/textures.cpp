// Textures. Mitsuba's v = 0 is the top row of an image and ours the bottom one, so that every image is turned by its mapping.

#include "framework/core/lists.h"
#include "framework/io/image/gamma.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace etendue {

namespace {

Rgb mean_of(const Texture& texture) {
  if (const auto* checks = std::get_if<CheckerTexture>(&texture)) return 0.5f * (checks->even + checks->odd);
  const auto& image = std::get<ImageTexture>(texture);
  const dvec3 sum = std::accumulate(image.texels.begin(), image.texels.end(), dvec3(0),
                                    [](const dvec3& s, const Rgb& texel) { return s + dvec3(texel); });
  return Rgb(static_cast<double>(image.gain) / static_cast<double>(image.texels.size()) * sum);
}

bool has_holes(const RgbImage& alpha) {
  return std::any_of(alpha.texels.begin(), alpha.texels.end(), [](const Rgb& texel) { return texel.x < 1; });
}

template <class Function>
void for_each_colour(Texture& texture, const Function& function) {
  if (auto* checks = std::get_if<CheckerTexture>(&texture)) {
    function(checks->even);
    function(checks->odd);
    return;
  }
  auto& image = std::get<ImageTexture>(texture);
  for (Rgb& texel : image.texels) {
    texel *= image.gain;
    function(texel);
  }
  image.gain = 1;
}

Wrap wrap_of(const std::string& mode) {
  if (mode == "repeat") return Wrap::repeat;
  if (mode == "mirror") return Wrap::mirror;
  return mode == "zero" ? Wrap::black : Wrap::clamp;
}

}  // namespace

std::span<const MitsubaReader::TextureType> MitsubaReader::texture_types() {
  using R = MitsubaReader;
  static constexpr TextureType table[] = {
      {"bitmap",
       "PNG, JPEG, TGA, BMP, HDR, PFM, EXR; sRGB unless raw, of another gamma or floats; filter_type nearest interpolates over "
       "1/16 "
       "of a texel at its edges, over more (warned) in images above 4096 texels; wrap_mode one approximated by clamp",
       &R::bitmap},
      {"checkerboard", "color0, color1, to_uv (or uscale, uoffset ...)", &R::checkerboard},
      {"scale", "a texture times a constant", &R::scaled},
      {"curvature", "approximated: grey of 0.5", &R::other_texture},
      {"gridtexture", "approximated: grey of 0.5", &R::other_texture},
      {"mesh_attribute", "approximated: grey of 0.5", &R::other_texture},
      {"vertexcolors", "approximated: grey of 0.5", &R::other_texture},
      {"volume", "approximated: grey of 0.5", &R::other_texture},
      {"wireframe", "approximated: grey of 0.5", &R::other_texture},
  };
  return table;
}

MitsubaReader::TextureValue MitsubaReader::texture(const XmlElement& element) {
  const auto [entry, is_new] = textures_.try_emplace(&element);
  if (!is_new && !entry->second) throw Error(element.where(), "texture: refers to itself");
  if (is_new) {
    const Nesting nesting(*this, element);
    const Properties of = properties(element);
    TextureValue value = (this->*find_type(texture_types(), of).handler)(of);
    of.finish();
    textures_[&element] = std::move(value);
  }
  if (const auto* read = std::get_if<Texture>(&*textures_[&element]))
    if (const auto* image = std::get_if<ImageTexture>(read))
      files_.need_memory(image->texels.size() * sizeof(Rgb), "the texture", element.where());  // for the copy
  return *textures_[&element];
}

MitsubaReader::UvMap MitsubaReader::uv_map(const Properties& of) {
  const float both = of.number("uvscale", 1);
  UvMap map{{of.number("uscale", both), of.number("vscale", both)}, {of.number("uoffset", 0), of.number("voffset", 0)}};
  if (version0()) {
    have_no_effect(of, {"to_uv"}, "as in Mitsuba 0.x");
    return map;
  }
  const Transform to_uv = of.transform("to_uv");
  const vec3 u = to_uv.vector({1, 0, 0}), v = to_uv.vector({0, 1, 0}), at = to_uv.point(vec3(0));
  if (std::abs(u.y) + std::abs(v.x) > 1e-4f * (std::abs(u.x) + std::abs(v.y)))
    approximate(of.where("to_uv"),
                fmt::format("{}: 'to_uv' turns the texture; only scales and offsets are supported", of.title()),
                "its scale and offset, without the turn");
  map.offset = map.offset * vec2(u.x, v.y) + vec2(at);
  map.scale *= vec2(u.x, v.y);
  return map;
}

float MitsubaReader::read_gamma(const Properties& of) {
  const float gamma = of.number("gamma", 0, -1, 10);
  if (gamma != -1 && gamma != 0 && gamma < 0.1f)
    of.fail("gamma", fmt::format("is {:g}; expected 0 (as the file says), -1 (sRGB), or 0.1 to 10", gamma));
  return gamma;
}

RgbImage MitsubaReader::read_coloured_image(const Properties& of, float gamma) {
  if (gamma == 0 && version0()) gamma = stated_gamma(read_file_of(of).bytes);  // later versions take every PNG as sRGB
  const bool is_srgb = gamma < 0.1f || gamma > 10;
  RgbImage image = read_image_of(of, is_srgb ? Encoding::srgb : Encoding::linear);
  if (!is_srgb && gamma != 1) decode_gamma(image, gamma);
  return image;
}

MitsubaReader::TextureValue MitsubaReader::bitmap(const Properties& of) {
  const float gamma = read_gamma(of);
  if (version0()) have_no_effect(of, {"raw"}, "as in Mitsuba 0.x");
  const bool raw = version0() ? gamma == 1 : of.boolean("raw", gamma == 1), has_gamma = gamma != 0 && gamma != 1;
  const std::string channel = in_lower_case(of.string("channel", "all"));
  const bool of_alpha = channel == "a";
  const std::size_t component = std::string_view("rgb").find(channel);
  const bool is_one = channel.size() == 1 && component < 3;
  if (channel != "all" && !of_alpha && !is_one)
    approximate(of.where("channel"),
                fmt::format("{}: 'channel' is '{}'; expected 'r', 'g', 'b', 'a' or none", of.title(), channel), "all of them");
  RgbImage image = of_alpha ? read_image_of(of, Encoding::alpha) : read_coloured_image(of, has_gamma ? gamma : raw ? 1 : 0);
  if (of_alpha && !has_holes(image))
    warn(of.where("channel"), fmt::format("'{}' is opaque, or of a format whose alpha is not read", file_name(of)));
  if (is_one)
    for (Rgb& texel : image.texels) texel = Rgb(texel[static_cast<int>(component)]);
  return image_texture(of, std::move(image));
}

MitsubaReader::TextureValue MitsubaReader::image_texture(const Properties& of, RgbImage image) {
  if (of.string("filter_type", "bilinear") == "nearest")
    if (const int times = repeat_texels(image, of.where("filter_type")); times < 16)
      warn(of.where("filter_type"), fmt::format("interpolated over 1/{} of a texel at the edges of each", times));
  const UvMap map = uv_map(of);
  of.ignore({"max_anisotropy", "cache", "format", "accel", "cache_id"});
  ImageTexture texture{.size = image.size,
                       .texels = std::move(image.texels),
                       .uv_scale = {map.scale.x, -map.scale.y},
                       .uv_offset = {map.offset.x, 1 - map.offset.y}};
  const std::string both = of.string("wrap_mode", "repeat");
  const std::string wrap = of.string("wrap_mode_u", both), wrap_v = of.string("wrap_mode_v", both);
  for (const std::string& mode : {wrap, wrap_v})
    if (mode != "repeat" && mode != "mirror" && mode != "clamp" && mode != "zero" && mode != "one")
      throw Error(of.where("wrap_mode"),
                  unknown_name("wrap mode", mode, std::vector<std::string>{"repeat", "mirror", "clamp", "zero", "one"}));
  if (wrap == "one" || wrap_v == "one")
    approximate(of.where("wrap_mode"),
                fmt::format("{}: 'wrap_mode' is 'one'; expected repeat, mirror, clamp or zero", of.title()),
                "clamp: it differs outside of 0 to 1");
  texture.wrap_u = wrap_of(wrap);
  texture.wrap_v = wrap_of(wrap_v);
  return Texture(std::move(texture));
}

// Takes the alpha channel of an image that has one, although Mitsuba takes the colours.
MitsubaReader::TextureValue MitsubaReader::opacity(const XmlElement& element) {
  if (is_colour(element)) return read_colour(element, ColourUse::reflectance);
  const Properties of = properties(element);
  if (of.type() == "bitmap" && !of.has("channel"))
    if (RgbImage alpha = read_image_of(of, Encoding::alpha); has_holes(alpha)) {
      approximate(of.where(), fmt::format("{}: Mitsuba takes the colours of '{}' for its opacity", of.title(), file_name(of)),
                  "its alpha channel");
      of.ignore({"raw", "gamma"});
      TextureValue value = image_texture(of, std::move(alpha));
      of.finish();
      return value;
    }
  return texture(element);
}

// Mitsuba's checks are half a unit wide.
MitsubaReader::TextureValue MitsubaReader::checkerboard(const Properties& of) {
  const UvMap map = uv_map(of);
  CheckerTexture checks{.uv_scale = 2.0f * map.scale, .uv_offset = 2.0f * map.offset};
  checks.even = colour(of, "color0", Rgb(0.4f), ColourUse::factor);
  checks.odd = colour(of, "color1", Rgb(0.2f), ColourUse::factor);
  return Texture(checks);
}

MitsubaReader::TextureValue MitsubaReader::scaled(const Properties& of) {
  Rgb factor(1);
  const XmlElement* nested = nullptr;
  for (const char* name : {"value", "scale"})
    if (const XmlElement* element = of.element(name); element && is_colour(*element))
      factor *= read_colour(*element, ColourUse::factor);
    else if (element)
      nested = element;
  for (const XmlElement* element : of.objects({"texture"})) nested = element;
  if (nested) {
    TextureValue value = texture(*nested);
    if (Rgb* constant = std::get_if<Rgb>(&value)) return *constant * factor;
    for_each_colour(std::get<Texture>(value), [&](Rgb& c) { c *= factor; });
    return value;
  }
  return factor;
}

MitsubaReader::TextureValue MitsubaReader::other_texture(const Properties& of) {
  of.ignore_all();
  approximate(of.where(), fmt::format("{} is not supported", of.title()), "grey of 0.5");
  return Rgb(0.5f);
}

std::uint32_t MitsubaReader::add_texture(Texture texture) {
  scene_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

// Its brightest channel becomes 1 and a factor of `radiance`.
std::uint32_t MitsubaReader::image_of_light(Texture image, Rgb& radiance) {
  float most = 0;
  for_each_colour(image, [&](Rgb& c) {
    c = glm::max(c, Rgb(0));
    most = std::max(most, max_component(c));
  });
  if (most > 0) for_each_colour(image, [most](Rgb& c) { c /= most; });
  radiance *= most;
  return add_texture(std::move(image));
}

TexturedRgb MitsubaReader::reflectance(const Properties& of, std::string_view name, const Rgb& otherwise, bool& textured,
                                       float internal_reflectance) {
  // Gives the base under a coat whose inner reflections, summed, give this one without them.
  const auto summed = [&](const Rgb& c) { return c / (1.0f - internal_reflectance * (1.0f - c)); };
  const XmlElement* element = of.element(name);
  if (!element || is_colour(*element)) return summed(element ? read_colour(*element, ColourUse::reflectance) : otherwise);
  const auto [entry, is_new] = scene_textures_.try_emplace({element, internal_reflectance}, 0);
  TextureValue value = is_new ? texture(*element) : TextureValue(Rgb(0));
  if (Rgb* constant = std::get_if<Rgb>(&value); is_new && constant) {
    scene_textures_.erase(entry);
    const float limit = limit_of_reflectance(element->where(), "texture", max_component(*constant));
    return summed(glm::clamp(limit * *constant, Rgb(0), Rgb(1)));
  }
  textured = true;
  TexturedRgb result;
  if (is_new) {
    float most = 0;
    for_each_colour(std::get<Texture>(value), [&](Rgb& c) { most = std::max(most, max_component(c)); });
    const float scale = limit_of_reflectance(element->where(), "texture", most);
    for_each_colour(std::get<Texture>(value), [&](Rgb& c) { c = summed(glm::clamp(scale * c, Rgb(0), Rgb(1))); });
    entry->second = add_texture(std::move(std::get<Texture>(value)));
  }
  result.texture = entry->second;
  return result;
}

Rgb MitsubaReader::colour(const Properties& of, std::string_view name, const Rgb& otherwise, ColourUse use) {
  const XmlElement* element = of.element(name);
  if (!element) return otherwise;
  if (is_colour(*element)) return read_colour(*element, use);
  const TextureValue value = texture(*element);
  const Rgb* const constant = std::get_if<Rgb>(&value);
  const Rgb found = constant ? *constant : mean_of(std::get<Texture>(value));
  if (!constant)
    approximate(of.where(name), fmt::format("{}: '{}' is a texture that varies; expected a constant", of.title(), name),
                "its mean");
  if (use != ColourUse::reflectance) return found;
  const float limit = limit_of_reflectance(of.where(name), of.title() + ": '" + std::string(name) + "'", max_component(found));
  return glm::clamp(limit * found, Rgb(0), Rgb(1));
}

float MitsubaReader::number(const Properties& of, std::string_view name, float otherwise, float low, float high) {
  const XmlElement* element = of.element(name);
  if (!element || element->tag == "float" || element->tag == "integer") return of.number(name, otherwise, low, high);
  return std::clamp(mean_component(colour(of, name, Rgb(otherwise), ColourUse::index)), low, high);
}

}  // namespace etendue
