// Renders a scene in a test: integrator, structure and parameters by name.
#pragma once

#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"
#include "integrators/registry.h"

#include <string>

namespace etendue::testing {

struct RenderOptions {
  ParamMap params;
  std::uint32_t iterations = 16;
  std::uint64_t seed = 1;
  ivec2 resolution{32, 32};
  int threads = 2;
  std::string accel = "binned-sah";
};

struct Rendered {
  Image image;
  std::uint64_t hash = 0, non_finite = 0;
  Expectation expectation;
};

inline Rendered render(const Scene& scene, const std::string& integrator_name, const RenderOptions& options) {
  const SceneNeeds needs = scene_needs(scene);
  LightSampler lights(scene);
  const auto rays = find_ray_structure(options.accel, {}).make(scene, {});
  const auto integrator = find_integrator(integrator_name, {}).make(options.params);
  PhaseTimes phases;
  RenderContext context{
      .scene = scene,
      .needs = needs,
      .rays = *rays,
      .lights = lights,
      .seed = options.seed,
      .resolution = options.resolution,
      .phases = phases,
      .make_points = [](const std::string& name) { return find_point_structure(name, {}).make(); },
      .make_records = [](const std::string& name, const Bounds& b) { return find_record_structure(name, {}).make(b); }};
  Film film(options.resolution);
  with_threads(options.threads, [&] {
    integrator->prepare(context);
    for (std::uint32_t i = 0; i < options.iterations; ++i) integrator->iteration(context, i, film);
  });
  return {film.mean(), film.hash(), film.non_finite_count(), integrator->expectation()};
}

// The closed form averaged over each pixel by 4x4 midpoints.
inline Image exact_image(const Scene& scene, ivec2 resolution) {
  Image image(resolution);
  for (int y = 0; y < resolution.y; ++y)
    for (int x = 0; x < resolution.x; ++x)
      for (int k = 0; k < 16; ++k) {
        const vec2 film = vec2(x, y) + vec2((k % 4 + 0.5f) / 4, (k / 4 + 0.5f) / 4);
        image.at(x, y) += scene.closed_form->radiance(scene.camera.ray(resolution, film, vec2(0.5f))) / 16.0;
      }
  return image;
}

}  // namespace etendue::testing
