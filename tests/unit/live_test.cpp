// Figures that a watched run tells of itself: samples of its rays, and means over its last iterations.
#include "experiments/run/live.h"
#include "accel/registry.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

#include <memory>

namespace etendue {
namespace {

std::vector<Ray> rays_into(const Scene& scene, int count) {
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const vec2 film = vec2(i % 64, i / 64) * vec2(scene.resolution) / 64.0f;
    rays.push_back(scene.camera.ray(scene.resolution, film, vec2(0.5f)));
  }
  return rays;
}

TEST(SampledRays, AnswerAsTheStructureDoes) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const auto structure = find_ray_structure("binned-sah", {}).make(scene, {});
  const SampledRays sampled(*structure);
  const std::vector<Ray> rays = rays_into(scene, 2048);
  std::vector<Hit> hits(rays.size()), expected(rays.size());
  const auto blocked = std::make_unique<bool[]>(rays.size());
  sampled.closest(rays, hits);
  sampled.occluded(rays, std::span(blocked.get(), rays.size()));
  structure->closest(rays, expected);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i].t, expected[i].t);
    EXPECT_EQ(sampled.closest(rays[i]).t, expected[i].t);
    EXPECT_EQ(sampled.occluded(rays[i]), structure->occluded(rays[i]));
    EXPECT_EQ(blocked[i], structure->occluded(rays[i]));
  }
}

TEST(SampledRays, CountOneQueryIn256) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto structure = find_ray_structure("binned-sah", {}).make(scene, {});
  const SampledRays sampled(*structure);
  for (const Ray& ray : rays_into(scene, 4096)) sampled.closest(ray);
  EXPECT_EQ(sampled.work().rays, 16u);
  EXPECT_EQ(sampled.work().full_rays, 16u);
  EXPECT_GT(sampled.work().tests, 16u);
}

// Brute force spares nothing.
TEST(LiveWindow, SharesAreAgainstBruteForce) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const auto saved = [&](const char* name) {
    const auto structure = find_ray_structure(name, {}).make(scene, {});
    const SampledRays sampled(*structure);
    LiveWindow window(scene);
    window.mark(0, {}, sampled.work());
    for (const Ray& ray : rays_into(scene, 4096)) sampled.closest(ray);
    CounterValues counters{};
    counters[static_cast<std::size_t>(Counter::rays)] = 4096;
    window.mark(0.5, counters, sampled.work());
    EXPECT_EQ(window.figures().rays_per_s, 8192);
    return window.figures().tests_saved.value();
  };
  EXPECT_NEAR(saved("brute"), 0, 1e-12);
  EXPECT_GT(saved("binned-sah"), 0.2);
  EXPECT_LT(saved("binned-sah"), 1);
}

TEST(LiveWindow, IsOfTheLast60Iterations) {
  LiveWindow window(load_scene("builtin:cornell-box"));
  CounterValues counters{};
  for (int i = 0; i <= 200; ++i) {
    counters[static_cast<std::size_t>(Counter::shadow_rays)] += i <= 140 ? 1000000 : 100;
    window.mark(i, counters, {});
  }
  EXPECT_EQ(window.figures().rays_per_s, 100);
  EXPECT_FALSE(window.figures().tests_per_ray);
  EXPECT_FALSE(LiveWindow(load_scene("builtin:furnace")).figures().tests_saved);
}

}  // namespace
}  // namespace etendue
