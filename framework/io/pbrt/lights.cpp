// Light sources. The colour of a light times its "scale" is radiance, intensity or irradiance as it stands.

#include "framework/io/image/octahedral.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr float degrees = pi / 180;
// W/(m^2 sr), W/sr or W/m^2, of a channel: its square, too, has room in single precision, and so has the power of a light.
constexpr float brightest = 1e12f;

Rgb emitted(const PbrtParams& params, std::string_view name) {
  for (const std::string_view photometric : {"power", "illuminance"})
    params.reject(photometric, fmt::format("give the light's '{}' itself", name));
  const Rgb value =
      params.colour(name, ColourUse::light).value_or(Rgb(1)) * params.colour("scale", ColourUse::light).value_or(Rgb(1));
  if (!is_finite(value)) params.fail(name, "times 'scale' leaves the range of single precision");
  if (max_component(value) > brightest)
    params.fail(name, fmt::format("is {:g}; expected {:g} at most", max_component(value), brightest));
  return value;
}

vec3 placed(const PbrtParams& params, const Transform& t, const vec3& from) {
  const vec3 position = t.point(from);
  if (!within_reach(position)) params.fail("from", fmt::format("lies, placed, beyond {:g} m", farthest));
  return position;
}

// What scales all that the light emits.
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

}  // namespace

void PbrtReader::area_light_source(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "AreaLightSource");
  if (type != "diffuse" && type != "area")
    throw Error(where, unknown_name("area light", type, std::vector<std::string>{"diffuse"}));
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token));
  params.reject("filename", "the radiance of an area light is constant");
  const Rgb radiance = emitted(params, "L");
  attributes_.glow = ShapeLook::Glow{radiance, params.boolean("twosided", false)};
  if (is_black(radiance)) attributes_.glow.reset();
  params.ignore({"samples", "nsamples"});
  params.finish();
}

void PbrtReader::light_source(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "LightSource");
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token));
  std::optional<Light> light;
  if (type == "point")
    light = point_light(params);
  else if (type == "spot")
    light = spot_light(params);
  else if (type == "distant")
    light = distant_light(params);
  else if (type == "infinite")
    light = infinite_light(lexer, params);
  else
    throw Error(where, unknown_name("light", type, std::vector<std::string>{"point", "spot", "distant", "infinite"}));
  params.ignore({"samples", "nsamples"});
  params.finish();
  if (is_black(emission(*light)))
    warn(params.where(), params.owner() + ": is black and left out");
  else
    scene_.lights.push_back(std::move(*light));
}

Light PbrtReader::point_light(const PbrtParams& params) const {
  return PointLight{.position = placed(params, attributes_.ctm, params.point("from", vec3(0))),
                    .intensity = emitted(params, "I")};
}

Light PbrtReader::spot_light(const PbrtParams& params) const {
  const vec3 from = params.point("from", vec3(0)), to = params.point("to", vec3(0, 0, 1));
  const float angle = params.number("coneangle", 30, 1e-3f, 180), delta = params.number("conedeltaangle", 5, 0, 180);
  if (delta > angle) params.fail("conedeltaangle", fmt::format("is {}; expected no more than coneangle, {}", delta, angle));
  return SpotLight{.position = placed(params, attributes_.ctm, from),
                   .direction = unit_direction(params, attributes_.ctm, from, to),
                   .intensity = emitted(params, "I"),
                   .cos_outer = std::cos(angle * degrees),
                   .cos_inner = std::cos((angle - delta) * degrees)};
}

// Light travels from 'from' to 'to'; L is the irradiance of a surface that faces it.
Light PbrtReader::distant_light(const PbrtParams& params) const {
  const vec3 from = params.point("from", vec3(0)), to = params.point("to", vec3(0, 0, 1));
  return DirectionalLight{.direction = unit_direction(params, attributes_.ctm, from, to), .irradiance = emitted(params, "L")};
}

Light PbrtReader::infinite_light(PbrtLexer& lexer, const PbrtParams& params) {
  params.reject("portal", "give the whole environment");
  const bool version4 = params.has("filename");
  if (version4 && params.has("mapname")) params.fail("mapname", "cannot stand beside 'filename'");
  if (version4 && params.has("L")) params.fail("L", "cannot stand beside 'filename'");
  EnvironmentLight light{.scale = emitted(params, "L"), .size = ivec2(0), .texels = {}, .light_to_world = attributes_.ctm};
  const std::string_view param = version4 ? "filename" : "mapname";
  const std::string file = params.string("filename", params.string("mapname", ""));
  if (file.empty()) {
    light.light_to_world = Transform();
    return light;
  }
  // Directions are looked up by the inverse; a transform that is no similarity would bend them unevenly.
  if (!attributes_.ctm.similarity_scale()) params.fail(param, "stands under a transform that distorts directions");
  RgbImage image = files_.image(file, *lexer.file(), params.where(param));
  warn_of_not_finite(image, params.where(param), file);
  if (version4 && image.size.x != image.size.y)
    throw Error(
        params.where(param),
        fmt::format(
            "'{}' is {} x {}: pbrt-v4's 'filename' expects a square octahedral image; give an equirectangular one as 'mapname'",
            file, image.size.x, image.size.y));
  if (version4) image = octahedral_to_equirectangular(image);
  light.size = image.size;
  light.texels = std::move(image.texels);
  float least = 0;
  for (Rgb& texel : light.texels) {
    least = std::min({least, texel.x, texel.y, texel.z});
    texel = glm::max(texel, Rgb(0));
  }
  if (least < 0)
    warn(params.where(param), fmt::format("'{}' falls to {:.4g}: no light is negative, clamped to 0", file, least));
  for (const Rgb& texel : light.texels)  // which are summed up both as they stand and scaled
    if (const float value = max_component(texel * glm::max(light.scale, Rgb(1))); value > brightest)
      params.fail(param, fmt::format("has a texel of {:g}, unscaled or scaled; expected {:g} at most", value, brightest));
  return light;
}

}  // namespace etendue
