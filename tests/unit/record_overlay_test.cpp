// Records drawn over a picture: where rims and centres fall, and that what is hidden does not show.
#include "experiments/harness/record_overlay.h"
#include "framework/io/load_scene.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::SceneContext;

constexpr ivec2 size{64, 64};

struct Seen {
  vec3 position, normal;
};

Seen seen_through(const RenderContext& context, const vec2& film) {
  const Ray ray = context.scene.camera.ray(size, film, vec2(0.5f));
  const SurfacePoint point = context.scene.surface_at(ray, context.rays.closest(ray));
  return {point.position, glm::dot(point.normal, ray.direction) > 0 ? -point.normal : point.normal};
}

std::size_t drawn(const RenderContext& context, const std::vector<RecordDisc>& records) {
  const Image overlay = draw_records(Image(size), context, records);
  return static_cast<std::size_t>(
      std::count_if(overlay.pixels.begin(), overlay.pixels.end(), [](const dvec3& p) { return p != dvec3(0); }));
}

TEST(RecordOverlay, DrawsCentreAndRim) {
  SceneContext scope(load_scene("builtin:cornell-box"), size);
  const RenderContext& context = scope.context;
  const vec2 film(40.5f, 12.5f);  // on the back wall
  const Seen centre = seen_through(context, film), beside = seen_through(context, film + vec2(6, 0));
  const RecordDisc record{centre.position, centre.normal, glm::length(beside.position - centre.position) * (1 + 1e-3f)};
  const Image overlay = draw_records(Image(size), context, std::vector{record});
  for (const ivec2 step : {ivec2(0, 0), ivec2(6, 0), ivec2(-6, 0)}) {
    const ivec2 pixel = ivec2(film) + step;
    EXPECT_NE(overlay.at(pixel.x, pixel.y), dvec3(0)) << step.x;
  }
  for (const ivec2 step : {ivec2(3, 0), ivec2(8, 0), ivec2(3, 2)}) {
    const ivec2 pixel = ivec2(film) + step;
    EXPECT_EQ(overlay.at(pixel.x, pixel.y), dvec3(0)) << step.x;
  }
}

TEST(RecordOverlay, HiddenRecordsDoNotShow) {
  SceneContext scope(load_scene("builtin:cornell-box"), size);
  const RenderContext& context = scope.context;
  const Seen front = seen_through(context, {40.5f, 12.5f});
  EXPECT_GT(drawn(context, {{front.position, front.normal, 0.3f}}), 3u);
  EXPECT_EQ(drawn(context, {{front.position, -front.normal, 0.3f}}), 0u);                       // of the wall's other side
  EXPECT_EQ(drawn(context, {{front.position - 5.0f * front.normal, front.normal, 0.3f}}), 0u);  // far behind it
  EXPECT_EQ(drawn(context, {}), 0u);
}

}  // namespace
}  // namespace etendue
