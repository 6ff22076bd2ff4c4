// Lights as data; sampling them is transport/light_sampling.h.
#pragma once

#include "framework/core/vec.h"
#include "framework/query.h"
#include "framework/scene/transform.h"

#include <cstdint>
#include <variant>
#include <vector>

namespace etendue {

// One emitting primitive of object 0. Emits on the side of the geometric normal, or on both.
struct AreaLight {
  std::uint32_t primitive = 0;
  Rgb radiance{1};  // W/(m^2 sr)
  bool two_sided = false;
  std::uint32_t texture = no_id;  // index into Scene::textures: what the radiance is multiplied by at each (u, v)
};

struct PointLight {
  vec3 position{0};
  Rgb intensity{1};  // W/sr
};

// Says how a spot fades from full intensity to none: by a cubic of the cosine, as in pbrt-v4, by its fourth power, as in
// pbrt-v3, or linearly in the angle, as in Mitsuba.
enum class SpotFade : std::uint8_t { cubic, quartic, linear };

// Full intensity within cos_inner of the axis, falling to 0 at cos_outer.
struct SpotLight {
  vec3 position{0};
  vec3 direction{0, 0, 1};
  Rgb intensity{1};
  float cos_outer = 0.8f, cos_inner = 0.9f;
  SpotFade fade = SpotFade::cubic;
};

struct DirectionalLight {
  vec3 direction{0, 0, -1};  // in which light travels, unit
  Rgb irradiance{1};         // W/m^2 on a surface facing it
};

// Radiance from infinity. A constant one has no image. Images are equirectangular: u over azimuth (from +x towards +y in light
// space), v from +z (row 0) to -z.
struct EnvironmentLight {
  Rgb scale{1};
  ivec2 size{0};
  std::vector<Rgb> texels;
  Transform light_to_world;
};

using Light = std::variant<AreaLight, PointLight, SpotLight, DirectionalLight, EnvironmentLight>;

// Is it of a point or of one direction, so that no ray can meet it?
inline bool is_delta(const Light& light) {
  return !std::holds_alternative<AreaLight>(light) && !std::holds_alternative<EnvironmentLight>(light);
}

// Is it an environment of one radiance in all directions?
inline bool is_even(const Light& light) {
  const auto* environment = std::get_if<EnvironmentLight>(&light);
  return environment != nullptr && environment->texels.empty();
}

}  // namespace etendue
