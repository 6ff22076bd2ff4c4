// Surfaces that let rays through, in every structure: holes are where the mask is 0, and of many rays the share of the opacity
// is stopped, layer by layer.
#include "accel/registry.h"
#include "framework/core/rng.h"
#include "framework/scene/builder.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

// Checks of a mask over the unit square, half a unit wide.
const CheckerTexture checks{.even = Rgb(1), .odd = Rgb(0), .uv_scale = vec2(4)};

MeshData square(float height) {
  MeshData mesh = quad({0, 0, height}, {1, 0, height}, {1, 1, height}, {0, 1, height});
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return mesh;
}

// A floor under `layers` squares with the mask, on lower ids than the floor where `floor_last`.
Scene masked_squares(const Texture& mask, int layers, bool floor_last) {
  SceneBuilder b("masks");
  const auto material = b.material(Diffuse{});
  if (!floor_last) b.mesh(square(0), material);
  for (int i = 1; i <= layers; ++i) b.mesh(square(0.25f * float(i)), material);
  if (floor_last) b.mesh(square(0), material);
  b.camera({0, 0, 5}, {0, 0, 0}, 40, {8, 8});
  Scene scene = b.finish();
  scene.textures.push_back(mask);
  for (std::size_t s = floor_last ? 0 : 1; s < static_cast<std::size_t>(layers) + !floor_last; ++s)
    scene.objects[0].shapes[s].mask = 0;
  return scene;
}

// The masked object once more, a unit to the right.
void instantiate(Scene& scene) {
  scene.objects.push_back(scene.objects[0]);
  scene.instances.push_back({1, Transform::translate({1, 0, 0})});
}

Ray down_ray(std::uint64_t i, float width) {
  Pcg32 rng(i, 1);
  const float x = rng.next_float();
  return {.origin = {width * x, rng.next_float(), 2}, .direction = {0, 0, -1}};
}

template <class Body>
void for_structures(const Body& body) {
  for (const RayEntry& entry : ray_structures())
    if (entry.available) {
      SCOPED_TRACE(entry.name);
      body(entry);
    }
}

TEST(Masks, HolesAreWhereTheMaskSays) {
  for (const bool floor_last : {false, true})
    for (const bool instanced : {false, true}) {
      Scene scene = masked_squares(checks, 2, floor_last);
      if (instanced) instantiate(scene);
      for_structures([&](const RayEntry& entry) {
        const auto structure = entry.make(scene, {});
        std::vector<Ray> rays;
        for (std::uint64_t i = 0; i < 300; ++i) rays.push_back(down_ray(i, instanced ? 2.0f : 1.0f));
        std::vector<Hit> hits(rays.size());
        const auto occluded = std::make_unique<bool[]>(rays.size());
        structure->closest(std::span<const Ray>(rays), std::span(hits));
        structure->occluded(std::span<const Ray>(rays), std::span(occluded.get(), rays.size()));
        for (std::size_t i = 0; i < rays.size(); ++i) {
          Ray ray = rays[i];
          const vec2 cell = glm::floor(4.0f * vec2(ray.origin.x - std::floor(ray.origin.x), ray.origin.y));
          const bool solid = std::fmod(cell.x + cell.y, 2.0f) == 0;
          const Hit one = structure->closest(ray);
          EXPECT_NEAR(one.t, solid ? 1.5f : 2.0f, 1e-5f);
          EXPECT_EQ(one.t, hits[i].t);
          EXPECT_EQ(one.primitive, hits[i].primitive);
          EXPECT_TRUE(structure->occluded(ray) && occluded[i]);
          ray.t_max = 1.9f;  // above the floor
          EXPECT_EQ(structure->occluded(ray), solid);
          TraversalCounters counters;
          EXPECT_EQ(structure->occluded_counted(ray, counters), solid);
          EXPECT_EQ(static_cast<bool>(structure->closest_counted(ray, counters)), solid);
        }
      });
    }
}

// Half-transparent layers decide independently of each other, and alike for the same ray.
TEST(Masks, EachLayerStopsItsShare) {
  const ImageTexture half{.size = {1, 1}, .texels = {Rgb(0.5f)}};
  const Scene scene = masked_squares(half, 3, true);
  for_structures([&](const RayEntry& entry) {
    const auto structure = entry.make(scene, {});
    constexpr int count = 4000;
    int through[4] = {};
    for (std::uint64_t i = 0; i < count; ++i) {
      const Ray ray = down_ray(i, 1);
      const Hit hit = structure->closest(ray);
      EXPECT_EQ(hit.t, structure->closest(ray).t);
      ++through[std::clamp(static_cast<int>(std::lround(4 * (hit.t - 1.25f))), 0, 3)];
    }
    for (int layer = 0; layer < 4; ++layer)
      EXPECT_NEAR(through[layer], count * std::pow(0.5, std::min(layer + 1, 3)), 150) << layer;
  });
}

TEST(Masks, OpaqueScenesHaveTheirStructureAlone) {
  Scene scene = masked_squares(checks, 1, true);
  for (Shape& shape : scene.objects[0].shapes) shape.mask = no_id;
  EXPECT_FALSE(scene.has_masks());
  const auto plain = find_ray_structure("sah", {}).make(scene, {}),
             built = find_ray_structure("sah", {}).build(scene, {}, nullptr);
  EXPECT_EQ(typeid(*plain), typeid(*built));
}

}  // namespace
}  // namespace etendue
