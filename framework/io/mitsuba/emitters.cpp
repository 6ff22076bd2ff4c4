// Emitters. Their spectra are radiance, intensity or irradiance as they stand.

#include "framework/core/elementary.h"
#include "framework/io/image/octahedral.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/mitsuba/sky.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr float brightest = 1e12f;  // of a channel: its square has room in single precision, and so has a light's power

// Light space of an EnvironmentLight (z up, azimuth from +x to +y) in Mitsuba's (y up, azimuth from -z to +x).
Transform light_to_emitter() { return *Transform::from_matrix(mat4(0, 0, -1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1)); }

vec3 unit(const Properties& of, const vec3& direction) {
  const double length = glm::length(dvec3(direction));
  if (!(length > 0) || !std::isfinite(length)) throw Error(of.where(), fmt::format("{}: has no direction", of.title()));
  return vec3(dvec3(direction) / length);
}

SunTime sun_time(const Properties& of) {
  SunTime when;
  when.year = of.integer("year", when.year, 1950, 2050);
  when.month = of.integer("month", when.month, 1, 12);
  when.day = of.integer("day", when.day, 1, 31);
  when.hour = of.number("hour", when.hour, -24, 48) + of.number("minute", 0, 0, 60) / 60 + of.number("second", 0, 0, 60) / 3600;
  when.latitude = of.number("latitude", when.latitude, -90, 90);
  when.longitude = of.number("longitude", when.longitude, -360, 360);
  when.timezone = of.number("timezone", when.timezone, -24, 24);
  return when;
}

}  // namespace

std::span<const MitsubaReader::EmitterType> MitsubaReader::emitter_types() {
  using R = MitsubaReader;
  static constexpr EmitterType table[] = {
      {"area",
       "in a shape, which is black without a bsdf; a texture as it is, of meshes where they have texture coordinates, else "
       "approximated by its mean",
       nullptr},
      {"point", "as it is", &R::point},
      {"spot", "as it is; a texture approximated by its mean, an uneven scale by a round cone", &R::spot},
      {"directional", "as it is", &R::directional},
      {"constant", "as it is", &R::constant},
      {"envmap", "as it is, interpolated between texels; from version 2 on the poles are the first and the last row",
       &R::environment},
      {"sky", "approximated by Preetham's clear sky", &R::sky},
      {"sun", "approximated by a directional light, from sun_direction or time and place", &R::sky},
      {"sunsky", "approximated by both", &R::sky},
      {"timed_sunsky", "approximated by both, at one time: the sun does not move", &R::sky},
      {"collimated", "approximated: left out", &R::left_out_emitter},
      {"directionalarea", "approximated: left out", &R::left_out_emitter},
      {"projector", "approximated: left out", &R::left_out_emitter},
      {"volumelight", "approximated: left out", &R::left_out_emitter},
  };
  return table;
}

void MitsubaReader::emitter(const XmlElement& element) {
  const Properties of = properties(element);
  const EmitterType& type = find_type(emitter_types(), of);
  if (!type.handler) return;  // an area emitter, which a shape refers to
  leave_out_media(of);
  of.ignore({"sampling_weight"});
  (this->*type.handler)(of);
  of.finish();
}

// Before version 2 environments and skies alone have a `scale`.
float MitsubaReader::scale_of(const Properties& of) {
  if (!version0()) return of.number("scale", 1, 0);
  have_no_effect(of, {"scale"}, "as in Mitsuba 0.x");
  return 1;
}

Rgb MitsubaReader::emitted(const Properties& of, std::string_view name) {
  const Rgb value = scale_of(of) * colour(of, name, Rgb(1), ColourUse::light);
  if (!is_finite(value) || max_component(value) > brightest)
    of.fail(name, fmt::format("is {:g}; expected {:g} at most", max_component(value), brightest));
  return value;
}

void MitsubaReader::add_light(const Properties& of, Light light, const Rgb& emitted) {
  if (is_black(emitted))
    warn(of.where(), of.title() + ": is black and left out");
  else
    scene_.lights.push_back(std::move(light));
}

vec3 MitsubaReader::placed_point(const Properties& of, const Transform& t, const vec3& p) const {
  const vec3 placed = t.point(p);
  if (!within_reach(placed)) throw Error(of.where(), fmt::format("{}: lies, placed, beyond {:g} m", of.title(), farthest));
  return placed;
}

void MitsubaReader::point(const Properties& of) {
  const Rgb intensity = emitted(of, "intensity");
  const vec3 position = placed_point(of, of.transform("to_world"), of.point("position", vec3(0)));
  add_light(of, PointLight{.position = position, .intensity = intensity}, intensity);
}

void MitsubaReader::spot(const Properties& of) {
  Rgb intensity = emitted(of, "intensity");
  if (of.has("texture")) intensity *= colour(of, "texture", Rgb(1), ColourUse::light);
  const Transform t = of.transform("to_world");
  const float cutoff = of.number("cutoff_angle", 20, narrowest_spot, 180);
  const float beam = of.number("beam_width", 0.75f * cutoff, 0, 180);
  if (beam > cutoff) of.fail("beam_width", fmt::format("is {}; expected no more than the cutoff angle, {}", beam, cutoff));
  if (!t.similarity_scale())
    approximate(of.where("to_world"), fmt::format("{}: 'to_world' distorts the cone", of.title()), "a round cone");
  add_light(of,
            SpotLight{.position = placed_point(of, t, vec3(0)),
                      .direction = unit(of, t.vector({0, 0, 1})),
                      .intensity = intensity,
                      .cos_outer = math::cos(cutoff * degrees),
                      .cos_inner = math::cos(beam * degrees),
                      .fade = SpotFade::linear},
            intensity);
}

void MitsubaReader::directional(const Properties& of) {
  const Rgb irradiance = emitted(of, "irradiance");
  const vec3 direction = of.transform("to_world").vector(of.point("direction", {0, 0, 1}));
  add_light(of, DirectionalLight{.direction = unit(of, direction), .irradiance = irradiance}, irradiance);
}

void MitsubaReader::constant(const Properties& of) {
  const Rgb radiance = emitted(of, "radiance");
  of.ignore({"to_world"});
  add_light(of, EnvironmentLight{.scale = radiance, .size = ivec2(0), .texels = {}, .light_to_world = {}}, radiance);
}

void MitsubaReader::environment(const Properties& of) {
  const Transform to_world = of.transform("to_world");
  if (!to_world.similarity_scale()) of.fail("to_world", "distorts directions; expected rotations and even scales");
  of.ignore({"cache", "mis_compensation"});
  EnvironmentLight light{.scale = Rgb(of.number("scale", 1, 0, brightest)),
                         .size = {},
                         .texels = {},
                         .light_to_world = to_world * light_to_emitter()};
  RgbImage image = read_coloured_image(of, read_gamma(of));
  light.size = image.size;
  light.texels = std::move(image.texels);
  float least = 0, most = 0;
  for (Rgb& texel : light.texels) {
    least = std::min({least, texel.x, texel.y, texel.z});
    texel = glm::max(texel, Rgb(0));
    most = std::max({most, max_component(texel), max_component(light.scale * texel)});
  }
  if (least < 0)
    warn(of.where("filename"), fmt::format("'{}' falls to {:.4g}: no light is negative, taken as 0", file_name(of), least));
  if (most > brightest) of.fail("filename", fmt::format("has a texel of {:g}; expected {:g} at most", most, brightest));
  const RowsOf rows = version0() ? RowsOf::centres : RowsOf::poles;
  interpolate_environment(light.size, light.texels, of.where("filename"), rows);
  const Rgb scale = light.scale;
  add_light(of, std::move(light), most > 0 ? scale : Rgb(0));
}

void MitsubaReader::sky(const Properties& of) {
  const bool has_sky = of.type() != "sun", has_sun = of.type() != "sky";
  approximate(of.where(), fmt::format("{} is not supported", of.title()),
              "Preetham's sky and a directional sun; brightness and colours differ");
  // Up is +z from version 2 on, and south +x; `sun_direction` is the world's in all versions.
  Transform to_world = of.transform("to_world");
  if (!version0()) to_world = to_world * Transform::rotate(0.5f * pi, {1, 0, 0});
  const vec3 then = towards_sun(sun_time(of));
  const vec3 sun = unit(of, of.has("sun_direction") ? to_world.inverse_vector(of.point("sun_direction", vec3(0)))
                            : version0()            ? then
                                                    : vec3(then.z, then.y, then.x));
  const float turbidity = of.number("turbidity", 3, 1, 10), scale = of.number("scale", 1, 0, 1e6f);
  const float sky_scale = scale * of.number("sky_scale", 1, 0, 1e6f), sun_scale = scale * of.number("sun_scale", 1, 0, 1e6f);
  if (has_sky) {
    EnvironmentLight light = preetham_sky(sun, turbidity);
    light.scale = Rgb(sky_scale);
    light.light_to_world = to_world * light_to_emitter();
    add_light(of, std::move(light), Rgb(sky_scale));
  }
  if (const Rgb irradiance = sun_scale * sun_irradiance(sun, turbidity); has_sun && sun.y > 0)
    add_light(of, DirectionalLight{.direction = unit(of, to_world.vector(-sun)), .irradiance = irradiance}, irradiance);
  of.ignore_all();
}

void MitsubaReader::left_out_emitter(const Properties& of) { leave_out_emitter(of, "is not supported"); }

void MitsubaReader::leave_out_emitter(const Properties& of, std::string_view why) {
  of.ignore_all();
  approximate(of.where(), fmt::format("{} {}", of.title(), why), "nothing: its light is missing");
}

std::optional<ShapeLook::Glow> MitsubaReader::area_emitter(const Properties& shape, bool has_uvs) {
  const auto found = shape.objects({"emitter", "luminaire"});
  if (found.empty()) return std::nullopt;
  if (found.size() > 1)
    throw Error(found[1]->where(), fmt::format("{}: has {} emitters; expected one", shape.title(), found.size()));
  const Properties of = properties(*found[0]);
  const EmitterType& type = find_type(emitter_types(), of);
  if (type.handler) {
    leave_out_emitter(of, type.handler == &MitsubaReader::left_out_emitter ? "is not supported"
                                                                           : "has no place in a shape, only an area light has");
    return std::nullopt;
  }
  leave_out_media(of);
  of.ignore({"sampling_weight"});
  const XmlElement* element = of.element("radiance");
  ShapeLook::Glow glow{Rgb(0), false};
  const TextureValue value = element && !is_colour(*element) && has_uvs ? texture(*element) : TextureValue(Rgb(0));
  if (const auto* image = std::get_if<Texture>(&value)) {
    glow.radiance = Rgb(scale_of(of));
    glow.texture = image_of_light(*image, glow.radiance);
    if (max_component(glow.radiance) > brightest)
      of.fail("radiance", fmt::format("is {:g}; expected {:g} at most", max_component(glow.radiance), brightest));
  } else {
    glow.radiance = emitted(of, "radiance");
  }
  of.finish();
  return is_black(glow.radiance) ? std::nullopt : std::optional(glow);
}

}  // namespace etendue
