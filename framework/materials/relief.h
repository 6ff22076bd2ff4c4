// Bump and normal maps: relief that is seen in the shading normal and not in the geometry.
//
// Heights h(u, v) over a surface move its normal n as if each point were lifted by h n ([Blinn1978]), the curvature of the
// surface below being left out: the new normal is n - grad h, with the gradient over the tangent plane. Heights are those of
// the image between its texels, so that slopes are constant along u and v within a texel and jump at its edges. A normal map
// states the normal itself, each component c as (c + 1) / 2, in the frame of n and of dp/du made perpendicular to n.
#pragma once

#include "framework/materials/texture.h"

#include <cstdint>

namespace etendue {

struct Relief {
  enum class Kind : std::uint8_t { heights, normals } kind = Kind::heights;
  std::uint32_t material = 0;  // whose surfaces have it: an index into Scene::materials
  std::uint32_t texture = 0;   // an index into Scene::textures
  float scale = 1;             // metres of a height of 1
};

// The surface point that a relief is applied to, in the world: dp_du and dp_dv need not be perpendicular to the normals, which
// are unit.
struct SmoothPoint {
  vec3 normal, shading_normal;  // geometric; interpolated, on the same side
  vec3 dp_du, dp_dv;
  vec2 uv;
};

// The shading normal with the relief, unit, on the side of the geometric normal; without it where dp_du and dp_dv are parallel.
vec3 normal_of_relief(const Relief& relief, const Texture& texture, const SmoothPoint& point);

}  // namespace etendue
