// The scenes and rays that break ray structures.
#pragma once

#include "framework/core/rng.h"
#include "framework/scene/scene.h"

#include <string>
#include <vector>

namespace etendue::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : pcg_(seed, 1) {}
  float unit() { return pcg_.next_float(); }
  float between(float low, float high) { return low + (high - low) * unit(); }
  std::uint32_t below(std::uint32_t n) { return pcg_.next() % n; }
  vec3 in_cube(float half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
  vec3 direction() {
    for (;;) {
      const vec3 v = in_cube(1);
      if (const float l = length_squared(v); l > 1e-3f && l < 1) return v / std::sqrt(l);
    }
  }

 private:
  Pcg32 pcg_;
};

struct RayCase {
  std::string name;
  Scene scene;
};

// Every kind of geometry, instance and plane that the structures must stand.
std::vector<RayCase> ray_cases();

// A sphere of triangles without a gap, about the origin.
Geometry closed_sphere(int rings, int sectors);

void add_triangle(Geometry& geometry, const vec3& a, const vec3& b, const vec3& c);
Scene scene_of(Geometry geometry);

// Rays in and around the scene: random, along the axes with zeros of both signs, of any length of direction, limited by t_min
// and t_max.
std::vector<Ray> general_rays(const Scene& scene, std::size_t count, std::uint64_t seed);
// Rays at edges and vertices of the scene's triangles, and from points on its faces.
std::vector<Ray> aimed_rays(const Scene& scene, std::size_t count, std::uint64_t seed);

}  // namespace etendue::testing
