// Questions that tests ask about a room without an opening (sealed_rooms.h): how much of the light outside a method sees
// inside, and whether rays that bounce about ever leave.
//
// With the environment variable ETENDUE_PRINT_LEAKS set, each case prints a line: pixels that are not black, and the largest
// and mean radiance as shares of the radiance outside.
#pragma once

#include "framework/core/sampling.h"
#include "framework/transport/ray_tools.h"
#include "tests/block_agreement.h"
#include "tests/sealed_rooms.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace etendue::testing {

// How each method is asked: few photons and samples.
struct SealedMethod {
  std::string name;
  std::string variant;
  ParamMap params = {};
  std::uint32_t iterations = 2;
  bool of_photons = false;  // a density estimate: what lies behind a curved wall may be declared, and bounded
};

// Every method of the registry. Where light is shut in between walls, each photon is stored ten times over: then fewer will do.
inline std::vector<SealedMethod> sealed_methods(const char* photons = "20000") {
  const auto few = [photons](std::initializer_list<std::pair<const char*, const char*>> more = {}) {
    ParamMap params = params_of(more);
    params["photons"] = parse_param_value(photons, {});
    return params;
  };
  std::vector<SealedMethod> methods;
  for (const IntegratorEntry& entry : integrators()) {
    const std::string& name = entry.name;
    if (name == "auto") continue;  // is one of the others
    if (name == "photon-map") {
      methods.push_back({name, "", few({{"caustic_photons", "5000"}}), 2, true});
      methods.push_back({name, " final_gather=4", few({{"caustic_photons", "5000"}, {"final_gather", "4"}}), 2, true});
    } else if (name == "photon-cache") {
      methods.push_back({name, "", few({{"caustic_photons", "5000"}, {"samples", "64"}}), 2, true});
      methods.push_back({name, " fill=density", few({{"caustic_photons", "5000"}, {"fill", "density"}}), 2, true});
    } else if (name.find("ppm") != std::string::npos) {
      methods.push_back({name, "", few(), 4, true});
    } else if (name == "vcm") {
      methods.push_back({name, "", params_of({{"neighbours", "1"}}), 8, true});
    } else if (name == "irradiance-cache" || name == "radiance-cache") {
      methods.push_back({name, "", params_of({{"samples", "64"}}), 2});
    } else {
      methods.push_back({name, "", {}, 8});
    }
  }
  return methods;
}

struct Leak {
  std::size_t pixels = 0;
  double largest = 0, mean = 0;  // shares of the radiance outside
};

inline Leak leak_of(const Image& image) {
  Leak leak;
  for (const dvec3& p : image.pixels) {
    const double share = std::max({p.x, p.y, p.z}) / light_outside;
    leak.pixels += p != dvec3(0);
    leak.largest = std::max(leak.largest, share);
    leak.mean += share / static_cast<double>(image.pixels.size());
  }
  return leak;
}

inline bool prints_leaks() {
  static const bool asked = std::getenv("ETENDUE_PRINT_LEAKS") != nullptr;
  return asked;
}

// `allowed`: of the mean, as a share of the radiance outside; 0: every pixel is black.
inline void expect_sealed(const Scene& scene, const SealedMethod& method, double allowed, const std::string& where = {},
                          const std::string& accel = "binned-sah", ivec2 resolution = {12, 12}) {
  RenderOptions options;
  options.params = method.params;
  options.iterations = method.iterations;
  options.resolution = resolution;
  options.accel = accel;
  const Rendered rendered = render(scene, method.name, options);
  const Leak leak = leak_of(rendered.image);
  const std::string subject = scene.name + where + ", " + method.name + method.variant + ", " + accel;
  if (prints_leaks())
    std::printf("%-90s %5zu of %zu pixels, max %.2e, mean %.2e\n", subject.c_str(), leak.pixels, rendered.image.pixels.size(),
                leak.largest, leak.mean);
  EXPECT_EQ(rendered.non_finite, 0u) << subject;
  if (allowed > 0)
    EXPECT_LE(leak.mean, allowed) << subject;
  else
    EXPECT_EQ(leak.pixels, 0u) << subject << ": up to " << leak.largest << " of the light outside";
}

// Rays that leave the walls inside of a room as paths do, and how many of them meet nothing, or a lamp outside.
struct Escapes {
  std::uint64_t rays = 0, escaped = 0, unoccluded = 0;
};

// Directions are of even density over the hemisphere, or along the wall, or aim at a corner of a triangle.
inline Escapes count_escapes(const Scene& scene, const RayQuery& rays, int paths, std::uint64_t seed = 1) {
  constexpr int bounces = 32;
  std::vector<vec3> corners;
  for (const Instance& instance : scene.instances)
    for (const vec3& p : scene.objects[instance.object].geometry.positions) corners.push_back(instance.to_world.point(p));
  const vec3 eye = scene.camera.to_world.point(vec3(0));
  Escapes escapes;
  for (int i = 0; i < paths; ++i) {
    Pcg32 random(mix_bits(seed), static_cast<std::uint64_t>(i));
    const auto u = [&] { return vec2(random.next_float(), random.next_float()); };
    Ray ray{.origin = eye, .direction = sample_unit_sphere(u())};
    for (int bounce = 0; bounce <= bounces; ++bounce) {
      const Hit hit = rays.closest(ray);
      ++escapes.rays;
      escapes.unoccluded += !rays.occluded(ray);
      if (!hit || scene.surface_at(ray, hit).light != no_id) {
        ++escapes.escaped;
        break;
      }
      const SurfacePoint point = scene.surface_at(ray, hit);
      const bool through = std::holds_alternative<Dielectric>(scene.materials[point.material]) && random.next_float() < 0.5f;
      const vec3 side = (glm::dot(ray.direction, point.normal) < 0) != through ? point.normal : -point.normal;
      vec3 local = sample_unit_sphere(u());
      local.z = std::abs(local.z);
      const float kind = random.next_float();
      if (kind < 0.3f) local = glm::normalize(vec3(local.x, local.y, local.z * std::pow(10.0f, -6 * random.next_float())));
      vec3 direction = Frame::from_normal(side).to_world(local);
      if (kind > 0.7f && !corners.empty()) {
        const auto corner = static_cast<std::size_t>(random.next_float() * static_cast<float>(corners.size()));
        const vec3 towards = corners[std::min(corner, corners.size() - 1)] - point.position;
        if (glm::dot(towards, side) > 0) direction = glm::normalize(towards);
      }
      if (!(glm::dot(direction, side) > 0)) break;
      ray = spawn_ray(point, direction);
    }
  }
  return escapes;
}

}  // namespace etendue::testing
