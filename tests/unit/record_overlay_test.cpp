// Records drawn over a picture: where rims and centres fall, and that what is hidden does not show.
#include "experiments/report/aov.h"
#include "framework/io/load_scene.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::SceneContext;

constexpr ivec2 overlay_size{64, 64};

struct Seen {
  vec3 position, normal;
};

Seen seen_through(const RenderContext& context, const vec2& film) {
  const Ray ray = context.scene.camera.ray(overlay_size, film, vec2(0.5f));
  const SurfacePoint point = context.scene.surface_at(ray, context.rays.closest(ray));
  return {point.position, glm::dot(point.normal, ray.direction) > 0 ? -point.normal : point.normal};
}

std::size_t drawn(const RenderContext& context, const std::vector<RecordShape>& records) {
  const Image overlay = draw_records(Image(overlay_size), context, records);
  return static_cast<std::size_t>(
      std::count_if(overlay.pixels.begin(), overlay.pixels.end(), [](const dvec3& p) { return p != dvec3(0); }));
}

TEST(RecordOverlay, DrawsCentreAndRim) {
  SceneContext scope(load_scene("builtin:cornell-box"), overlay_size);
  const RenderContext& context = scope.context;
  const vec2 film(40.5f, 12.5f);  // on the ceiling
  const Seen centre = seen_through(context, film), beside = seen_through(context, film + vec2(6, 0));
  const RecordShape record{centre.position, centre.normal, glm::length(beside.position - centre.position) * (1 + 1e-3f)};
  const Image overlay = draw_records(Image(overlay_size), context, std::vector{record});
  for (const ivec2 step : {ivec2(0, 0), ivec2(6, 0), ivec2(-6, 0)}) {
    const ivec2 pixel = ivec2(film) + step;
    EXPECT_NE(overlay.at(pixel.x, pixel.y), dvec3(0)) << step.x;
  }
  for (const ivec2 step : {ivec2(3, 0), ivec2(8, 0), ivec2(3, 2)}) {
    const ivec2 pixel = ivec2(film) + step;
    EXPECT_EQ(overlay.at(pixel.x, pixel.y), dvec3(0)) << step.x;
  }
}

TEST(RecordOverlay, DrawsEllipsesAndCubes) {
  SceneContext scope(load_scene("builtin:cornell-box"), overlay_size);
  const RenderContext& context = scope.context;
  const vec2 film(40.5f, 22.5f);  // on the back wall
  const Seen centre = seen_through(context, film), beside = seen_through(context, film + vec2(6, 0));
  const vec3 way = beside.position - centre.position;
  const float radius = glm::length(way) * (1 + 1e-3f);
  // Half as wide along the way as across it: sqrt(1 + anisotropy^2) = 2.
  const RecordShape ellipse{centre.position, centre.normal, radius, std::sqrt(3.0f) * glm::normalize(way)};
  const Image drawn_ellipse = draw_records(Image(overlay_size), context, std::vector{ellipse});
  for (const ivec2 step : {ivec2(3, 0), ivec2(-3, 0), ivec2(0, 6), ivec2(0, -6)})
    EXPECT_NE(drawn_ellipse.at(40 + step.x, 22 + step.y), dvec3(0)) << step.x << " " << step.y;
  for (const ivec2 step : {ivec2(6, 0), ivec2(-6, 0), ivec2(0, 3)})
    EXPECT_EQ(drawn_ellipse.at(40 + step.x, 22 + step.y), dvec3(0)) << step.x << " " << step.y;
  const RecordShape cube{centre.position, centre.normal, radius, vec3(0), true};
  const Image drawn_cube = draw_records(Image(overlay_size), context, std::vector{cube});
  for (const ivec2 step : {ivec2(6, 0), ivec2(6, -5), ivec2(-5, 6), ivec2(0, 6)})
    EXPECT_NE(drawn_cube.at(40 + step.x, 22 + step.y), dvec3(0)) << step.x << " " << step.y;
  for (const ivec2 step : {ivec2(0, 0), ivec2(3, 3), ivec2(8, 0), ivec2(-6, 0), ivec2(0, -6)})
    EXPECT_EQ(drawn_cube.at(40 + step.x, 22 + step.y), dvec3(0)) << step.x << " " << step.y;
}

TEST(RecordOverlay, HiddenRecordsDoNotShow) {
  SceneContext scope(load_scene("builtin:cornell-box"), overlay_size);
  const RenderContext& context = scope.context;
  const Seen front = seen_through(context, {40.5f, 12.5f});
  EXPECT_GT(drawn(context, {{front.position, front.normal, 0.3f}}), 3u);
  EXPECT_EQ(drawn(context, {{front.position, -front.normal, 0.3f}}), 0u);                       // of the wall's other side
  EXPECT_EQ(drawn(context, {{front.position - 5.0f * front.normal, front.normal, 0.3f}}), 0u);  // far behind it
  EXPECT_EQ(drawn(context, {}), 0u);
}

}  // namespace
}  // namespace etendue
