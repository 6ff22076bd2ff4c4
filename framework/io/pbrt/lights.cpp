// Light sources. The colour of a light times its "scale" is radiance, intensity or irradiance as it stands.

#include "framework/core/elementary.h"
#include "framework/io/image/octahedral.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr float degrees = pi / 180;

vec3 placed(const PbrtParams& params, const Transform& t, const vec3& from) {
  const vec3 position = t.point(from);
  if (!within_reach(position)) params.fail("from", fmt::format("lies, placed, beyond {:g} m", farthest));
  return position;
}

// The mean of an image as a factor of a light, which a stated power makes one of luminance 1, as pbrt-v4 divides by the image.
Rgb of_stated_power(const PbrtParams& params, const Rgb& mean) {
  const float brightness = luminance(mean);
  return params.number("power", -1) > 0 && brightness > 0 ? mean / brightness : mean;
}

// The factor that scales all that the light emits.
Rgb emission(const Light& light) {
  struct Visitor {
    Rgb operator()(const AreaLight& l) const { return l.radiance; }
    Rgb operator()(const PointLight& l) const { return l.intensity; }
    Rgb operator()(const SpotLight& l) const { return l.intensity; }
    Rgb operator()(const DirectionalLight& l) const { return l.irradiance; }
    Rgb operator()(const EnvironmentLight& l) const { return l.scale; }
  };
  return std::visit(Visitor{}, light);
}

vec3 unit_direction(const PbrtParams& params, const Transform& t, const vec3& from, const vec3& to) {
  const dvec3 direction(t.vector(to - from));
  const double length = glm::length(direction);
  if (!(length > 0) || !std::isfinite(length)) params.fail("to", "has no direction from 'from'");
  return vec3(direction / length);
}

// The illuminance of a surface that faces +z, as pbrt-v4 takes it: half of what the upper half of the map brings it.
double illuminance_of(const EnvironmentLight& map) {
  double sum = 0;
  for (int y = 0; y < map.size.y; ++y) {
    const double theta = pi * (y + 0.5) / map.size.y;
    if (theta >= 0.5 * pi) break;
    double row = 0;
    for (int x = 0; x < map.size.x; ++x)
      row += luminance(map.texels[static_cast<std::size_t>(y) * map.size.x + static_cast<std::size_t>(x)]);
    sum += math::cos(theta) * math::sin(theta) * row;
  }
  return 0.5 * sum * (pi / map.size.y) * (2 * pi / map.size.x);
}

}  // namespace

Rgb PbrtReader::emitted(const PbrtParams& params, std::string_view name, std::string_view photometric,
                        float power_of_unit) const {
  for (const std::string_view other : {"power", "illuminance"})
    if (other != photometric) params.reject(other, fmt::format("give the light's '{}' itself", name));
  const float power = params.number(photometric, -1);
  const auto colour = [&](std::string_view of) { return params.colour(of, ColourUse::light).value_or(Rgb(1)); };
  const Rgb value = colour(name) * colour("scale") * (power > 0 ? power / power_of_unit : 1.0f);
  if (!is_finite(value)) params.fail(name, "times 'scale' leaves the range of single precision");
  if (max_component(value) > brightest)
    params.fail(name, fmt::format("is {:g}; expected {:g} at most", max_component(value), brightest));
  return value;
}

PbrtParams PbrtReader::light_params(PbrtLexer& lexer, const Token& token, const std::string& type) {
  PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  params.add_defaults(attributes_.defaults["light"]);
  if (version3_)
    for (const char* name : {"power", "illuminance"}) params.drop(name, "which knows none");
  return params;
}

void PbrtReader::area_light_source(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "AreaLightSource");
  require_known("AreaLightSource", "area light", type, where);
  const PbrtParams params = light_params(lexer, token, type);
  Rgb radiance = emitted(params, "L", "power");
  const std::uint32_t texture = params.has("filename") ? image_of_light(lexer, params, radiance) : no_id;
  attributes_.glow = ShapeLook::Glow{radiance, params.boolean("twosided", false), texture};
  if (is_black(radiance)) attributes_.glow.reset();
  attributes_.glows_by_power = params.number("power", -1) > 0;
  if (attributes_.glows_by_power && texture != no_id)
    params.fail("power", "beside 'filename' is not supported: give the light's 'L' itself");
  params.ignore({"samples", "nsamples"});
  params.finish();
}

// For a light, version 3 takes the integers of an image as they are.
RgbImage PbrtReader::image_file_of_light(PbrtLexer& lexer, const PbrtParams& params, std::string_view param) {
  const std::string file = params.string(param, "");
  RgbImage image = files_.image(file, *lexer.file(), params.where(param), version3_ ? Encoding::linear : Encoding::srgb);
  warn_of_texels(image, params.where(param), file, true);
  return image;
}

// An image over (u, v), clamped at its edges as by version 4; its brightest channel becomes 1 and a factor of `radiance`.
std::uint32_t PbrtReader::image_of_light(PbrtLexer& lexer, const PbrtParams& params, Rgb& radiance) {
  RgbImage image = image_file_of_light(lexer, params, "filename");
  float most = 0;
  for (Rgb& texel : image.texels) {
    texel = glm::max(texel, Rgb(0));
    most = std::max(most, max_component(texel));
  }
  radiance *= most;
  if (max_component(radiance) > brightest)
    params.fail("filename", fmt::format("makes the light {:g}; expected {:g} at most", max_component(radiance), brightest));
  ImageTexture texture{.size = image.size, .texels = std::move(image.texels), .gain = most > 0 ? 1 / most : 0};
  texture.wrap_u = texture.wrap_v = Wrap::clamp;
  return add_texture(std::move(texture));
}

void PbrtReader::light_source(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "LightSource");
  require_known("LightSource", "light", type, where);
  const PbrtParams params = light_params(lexer, token, type);
  std::optional<Light> light;
  if (type == "point")
    light = point_light(params);
  else if (type == "spot")
    light = spot_light(params);
  else if (type == "distant")
    light = distant_light(params);
  else if (type == "infinite")
    light = infinite_light(lexer, params);
  else if (type == "goniometric")
    light = goniometric_light(lexer, params);
  else
    light = projection_light(lexer, params);
  params.ignore({"samples", "nsamples"});
  params.finish();
  if (is_black(emission(*light)))
    warn(params.where(), params.owner() + ": is black and left out");
  else
    scene_.lights.push_back(std::move(*light));
}

// Version 3 adds 'from' to where the transform places the origin.
Light PbrtReader::point_light(const PbrtParams& params) const {
  const vec3 from = params.point("from", vec3(0));
  const Transform t = version3_ ? Transform::translate(from) * ctm() : ctm();
  return PointLight{.position = placed(params, t, version3_ ? vec3(0) : from),
                    .intensity = emitted(params, "I", "power", 4 * pi)};
}

// An image that says where light goes has its mean over the sphere, by the rows' solid angle, or over a square.
PbrtReader::MeanImage PbrtReader::mean_of_image(PbrtLexer& lexer, const PbrtParams& params, bool sphere) {
  const std::string_view param = params.has("mapname") ? "mapname" : "filename";
  const std::string file = params.string(param, "");
  if (file.empty()) return {};
  const RgbImage image = image_file_of_light(lexer, params, param);
  const bool by_rows = sphere && image.size.x != image.size.y;
  dvec3 sum(0);
  double weights = 0;
  for (int y = 0; y < image.size.y; ++y) {
    const double weight = by_rows ? math::sin(pi * (y + 0.5) / image.size.y) : 1;
    for (int x = 0; x < image.size.x; ++x)
      sum += weight * dvec3(image.texels[static_cast<std::size_t>(y) * image.size.x + static_cast<std::size_t>(x)]);
    weights += weight * image.size.x;
  }
  return {glm::max(Rgb(sum / weights), Rgb(0)), image.size};
}

Light PbrtReader::goniometric_light(PbrtLexer& lexer, const PbrtParams& params) {
  approximate(params.where(), "LightSource \"goniometric\": lights have no image",
              "a point light of the same power, the same in all directions");
  params.ignore({"fov"});
  Rgb mean = mean_of_image(lexer, params, true).colour;
  if (!version3_) mean = Rgb(mean_component(mean));  // version 4 reads numbers
  return PointLight{.position = placed(params, ctm(), params.point("from", vec3(0))),
                    .intensity = emitted(params, "I", "power", 4 * pi) * of_stated_power(params, mean)};
}

// A cone over the same solid angle as the rectangle that the image covers, whose shorter side 'fov' spans.
Light PbrtReader::projection_light(PbrtLexer& lexer, const PbrtParams& params) {
  approximate(params.where(), "LightSource \"projection\": lights have no image",
              "a spot of its mean colour over the same solid angle");
  const MeanImage mean = mean_of_image(lexer, params, false);
  const float half = math::tan(0.5f * params.number("fov", version3_ ? 45 : 90, 2 * narrowest_spot, 170) * degrees);
  const vec2 halves = half * vec2(mean.size) / static_cast<float>(std::min(mean.size.x, mean.size.y));
  const vec2 sines = halves / glm::sqrt(1.0f + halves * halves);
  const float solid_angle = 4 * math::asin(sines.x * sines.y);
  const float cosine = std::clamp(1 - solid_angle / (2 * pi), -0.99f, 0.9999999f);
  const float power_of_unit = 2 * pi * (1 - cosine);
  return SpotLight{.position = placed(params, ctm(), params.point("from", vec3(0))),
                   .direction = unit_direction(params, ctm(), vec3(0), {0, 0, 1}),
                   .intensity = emitted(params, "I", "power", power_of_unit) * of_stated_power(params, mean.colour),
                   .cos_outer = cosine - 1e-4f * (1 - cosine),
                   .cos_inner = cosine};
}

Light PbrtReader::spot_light(const PbrtParams& params) {
  const vec3 from = params.point("from", vec3(0)), to = params.point("to", vec3(0, 0, 1));
  const float angle = params.number("coneangle", 30, narrowest_spot, 180);
  const bool states_delta = params.has("conedeltaangle") || params.has("conedelta");
  const float delta = params.number("conedeltaangle", params.number("conedelta", 5, 0, 180), 0, 180);
  if (states_delta && delta > angle)
    params.fail("conedeltaangle", fmt::format("is {}; expected no more than coneangle, {}", delta, angle));
  if (!ctm().similarity_scale())
    approximate(params.where(), params.owner() + ": its transform distorts the cone", "a round cone");
  // Where the five degrees that are not stated are more than the cone, pbrt's fading begins on the axis' other side.
  const float begins = std::abs(angle - delta);
  if (begins > angle && !version3_)
    warn(params.where("coneangle"), params.owner() +
                                        ": has an even light and a hard edge, as in pbrt-v3; pbrt-v4 fades over "
                                        "'conedeltaangle', 5 degrees if it is not stated, and lights what lies "
                                        "outside such a narrow cone");
  const float outer = math::cos(angle * degrees), inner = math::cos(std::min(begins, angle) * degrees);
  return SpotLight{.position = placed(params, ctm(), from),
                   .direction = unit_direction(params, ctm(), from, to),
                   .intensity = emitted(params, "I", "power", 2 * pi * (1 - 0.5f * (inner + outer))),
                   .cos_outer = outer,
                   .cos_inner = inner,
                   .fade = version3_ ? SpotFade::quartic : SpotFade::cubic};
}

// Light travels from 'from' to 'to'; L is the irradiance of a surface that faces it.
Light PbrtReader::distant_light(const PbrtParams& params) const {
  const vec3 from = params.point("from", vec3(0)), to = params.point("to", vec3(0, 0, 1));
  return DirectionalLight{.direction = unit_direction(params, ctm(), from, to),
                          .irradiance = emitted(params, "L", "illuminance")};
}

Light PbrtReader::infinite_light(PbrtLexer& lexer, const PbrtParams& params) {
  params.approximate("portal", "give the whole environment", "light from everywhere, through the portal or not");
  const bool version4 = params.has("filename");
  if (version4 && params.has("mapname")) params.fail("mapname", "cannot stand beside 'filename'");
  if (version4 && params.has("L")) params.fail("L", "cannot stand beside 'filename'");
  const bool constant = !version4 && !params.has("mapname");
  EnvironmentLight light{.scale = emitted(params, "L", "illuminance", pi),
                         .size = ivec2(0),
                         .texels = {},
                         .light_to_world = constant ? Transform() : ctm()};
  const std::string_view param = version4 ? "filename" : "mapname";
  const std::string file = params.string("filename", params.string("mapname", ""));
  if (file.empty()) {
    light.light_to_world = Transform();
    return light;
  }
  // Directions are looked up by the inverse; a transform that is no similarity would bend them unevenly.
  if (!ctm().similarity_scale()) params.fail(param, "stands under a transform that distorts directions");
  RgbImage image = image_file_of_light(lexer, params, param);
  const bool square = image.size.x == image.size.y;
  if (version4 && !square)
    approximate(
        params.where(param),
        fmt::format(
            "'{}' is {} x {}: pbrt-v4's 'filename' expects a square octahedral image; give an equirectangular one as 'mapname'",
            file, image.size.x, image.size.y),
        "equirectangular");
  if (version4 && square) image = octahedral_to_equirectangular(image);
  light.size = image.size;
  light.texels = std::move(image.texels);
  float least = 0;
  for (Rgb& texel : light.texels) {
    least = std::min({least, texel.x, texel.y, texel.z});
    texel = glm::max(texel, Rgb(0));
  }
  if (params.has("illuminance")) {
    const double own = illuminance_of(light);
    if (!(own > 0)) params.fail("illuminance", fmt::format("cannot be that of '{}', which is black above", file));
    light.scale *= static_cast<float>(pi / own);
    if (!is_finite(light.scale)) params.fail("illuminance", "leaves the range of single precision");
  }
  if (least < 0)
    warn(params.where(param), fmt::format("'{}' falls to {:.4g}: no light is negative, clamped to 0", file, least));
  for (const Rgb& texel : light.texels)  // which are summed up both as they stand and scaled
    if (const float value = max_component(texel * glm::max(light.scale, Rgb(1))); value > brightest)
      params.fail(param, fmt::format("has a texel of {:g}, unscaled or scaled; expected {:g} at most", value, brightest));
  if (version3_) interpolate_environment(light.size, light.texels, params.where(param));  // version 4 takes the nearest texel
  return light;
}

}  // namespace etendue
