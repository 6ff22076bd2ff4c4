// Vectors, boxes and frames: GLM names in our namespace, plus the few geometric helpers everything shares.
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace etendue {

using glm::dvec2;
using glm::dvec3;
using glm::ivec2;
using glm::mat3;
using glm::mat4;
using glm::uvec2;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

// Named so that code over lanes (lanes.h) finds them for one float, too; GLM's and lanes' own are found by their arguments.
using std::abs;
using std::copysign;
using std::floor;
using std::max;
using std::min;
using std::sqrt;

using Rgb = vec3;  // linear RGB: radiance in W/(m^2 sr), power in W, reflectance without unit

inline constexpr float pi = std::numbers::pi_v<float>;
inline constexpr float inv_pi = std::numbers::inv_pi_v<float>;
inline constexpr float infinity = std::numeric_limits<float>::infinity();

inline float luminance(const Rgb& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
// Without the branches of GLM's operator[], which nothing predicts where the axis depends on data.
inline float component(const vec3& v, int axis) {
  static_assert(sizeof(vec3) == 3 * sizeof(float));
  return (&v.x)[axis];
}
// The place of a pixel in an image of `size`, row by row: what its random numbers and its state go by.
constexpr std::size_t pixel_index(ivec2 pixel, ivec2 size) { return static_cast<std::size_t>(pixel.y) * size.x + pixel.x; }

inline float max_component(const vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline float mean_component(const vec3& v) { return (v.x + v.y + v.z) * (1.0f / 3.0f); }
inline bool is_black(const Rgb& c) { return c.x == 0 && c.y == 0 && c.z == 0; }
inline bool is_finite(const vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
inline float square(float x) { return x * x; }
inline float length_squared(const vec3& v) { return glm::dot(v, v); }
inline float safe_sqrt(float x) { return std::sqrt(std::max(0.0f, x)); }

// Axis-aligned box. A default one is empty: extending it by a point gives that point.
struct Bounds {
  vec3 lower{infinity};
  vec3 upper{-infinity};

  void extend(const vec3& p) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  }
  void extend(const Bounds& b) {
    lower = glm::min(lower, b.lower);
    upper = glm::max(upper, b.upper);
  }
  bool empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  vec3 diagonal() const { return upper - lower; }
  vec3 centre() const { return 0.5f * lower + 0.5f * upper; }
  // Half the surface area; 0 for an empty box.
  float half_area() const {
    if (empty()) return 0;
    const vec3 d = diagonal();
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }
  int longest_axis() const {
    const vec3 d = diagonal();
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  }
  bool contains(const vec3& p) const {
    return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z && p.z <= upper.z;
  }
};

// Orthonormal basis around a unit normal ([Duff2017]): no branch on the normal's direction but its sign. `V` is a vector of
// floats, or one of lanes.
template <class V>
struct FrameOf {
  V tangent, bitangent, normal;

  static FrameOf from_normal(const V& n) {
    const auto sign = copysign(1.0f, n.z);
    const auto a = -1.0f / (sign + n.z);
    const auto b = n.x * n.y * a;
    return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  V to_local(const V& v) const { return {dot(v, tangent), dot(v, bitangent), dot(v, normal)}; }
  V to_world(const V& v) const { return v.x * tangent + v.y * bitangent + v.z * normal; }
};
using Frame = FrameOf<vec3>;

}  // namespace etendue
