#include "framework/scenes/heaps.h"

#include "framework/core/elementary.h"
#include "framework/core/rng.h"
#include "framework/core/sampling.h"
#include "framework/scenes/meshes.h"

namespace etendue {

namespace {

// Seen from outside under an even sky.
Scene heap(const char* name, const MeshData& mesh, float width) {
  SceneBuilder b(name);
  b.mesh(mesh, b.material(Diffuse{Rgb(0.6f)}));
  b.light(EnvironmentLight{});
  b.camera(width * vec3(0.3f, 0.6f, 2), vec3(0), 45, {128, 128});
  return b.finish();
}

// A triangle about its centroid, with a side of `length` across a height of `width`, turned at random.
void add_triangle(MeshData& mesh, Pcg32& rng, const vec3& centroid, float length, float width) {
  const vec2 u(rng.next_float(), rng.next_float());
  const float z = 2 * u.x - 1, turn = 2 * pi * u.y, r = std::sqrt(std::max(0.0f, 1 - z * z));
  const Frame frame = Frame::from_normal({r * math::cos(turn), r * math::sin(turn), z});
  const float across = 2 * pi * rng.next_float();
  const vec3 along = frame.to_world({0, 0, 1}), aside = frame.to_world({math::cos(across), math::sin(across), 0});
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(centroid - 0.5f * length * along - width / 3 * aside);
  mesh.positions.push_back(centroid + 0.5f * length * along - width / 3 * aside);
  mesh.positions.push_back(centroid + 2 * width / 3 * aside);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

MeshData scattered(int triangles, float spread, float length, float width) {
  MeshData mesh;
  Pcg32 rng(hash_keys(std::uint64_t{17}), 1);
  for (int i = 0; i < triangles; ++i) {
    const vec3 u(rng.next_float(), rng.next_float(), rng.next_float());
    add_triangle(mesh, rng, spread * (u - 0.5f), length, width);
  }
  return mesh;
}

}  // namespace

Scene make_coincident(const CoincidentParams& params) {
  const MeshData ball = rough_ball(vec3(0), 0.5f, 500);
  MeshData mesh = ball;
  for (int copy = 1; copy < params.copies; ++copy)
    mesh.triangles.insert(mesh.triangles.end(), ball.triangles.begin(), ball.triangles.end());
  return heap("builtin:coincident", mesh, 1);
}

Scene make_slivers(const SliversParams& params) {
  constexpr float area = 2e-6f;
  const float length = std::sqrt(2 * area * params.aspect);
  return heap("builtin:slivers", scattered(params.triangles, 1, length, length / params.aspect), 1);
}

Scene make_overlap(const OverlapParams& params) {
  return heap("builtin:overlap", scattered(params.triangles, params.spread, 1, 1), 1 + params.spread);
}

}  // namespace etendue
