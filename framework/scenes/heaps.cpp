// Built-in scenes of triangles that boxes cannot tell apart, where structures take time and memory and no image goes wrong.
#include "framework/core/elementary.h"
#include "framework/core/rng.h"
#include "framework/core/sampling.h"
#include "framework/scenes/builtin_scenes.h"
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

struct CoincidentParams {
  int copies = 1;
};

template <class Visitor>
void describe(Visitor& v, CoincidentParams& p) {
  v.integer("copies", p.copies, 1, 10'000, "copies", "of a ball of 500 triangles, all in the same place");
}

Scene make_coincident(const CoincidentParams& params) {  // a ray that meets one meets all copies
  const MeshData ball = rough_ball(vec3(0), 0.5f, 500);
  MeshData mesh = ball;
  for (int copy = 1; copy < params.copies; ++copy)
    mesh.triangles.insert(mesh.triangles.end(), ball.triangles.begin(), ball.triangles.end());
  return heap("builtin:coincident", mesh, 1);
}

struct SliversParams {
  float aspect = 1;
  int triangles = 5'000;
};

template <class Visitor>
void describe(Visitor& v, SliversParams& p) {
  v.number("aspect", p.aspect, 1, 1e5, "1", "length of the triangles over their width, of the same area at any");
  v.integer("triangles", p.triangles, 100, 5'000'000, "triangles", "in a cube of one metre");
}

// They lie diagonally: the box of each is as long, wide and high as the triangle is long.
Scene make_slivers(const SliversParams& params) {
  constexpr float area = 2e-6f;
  const float length = std::sqrt(2 * area * params.aspect);
  return heap("builtin:slivers", scattered(params.triangles, 1, length, length / params.aspect), 1);
}

struct OverlapParams {
  float spread = 10;
  int triangles = 2'000;
};

template <class Visitor>
void describe(Visitor& v, OverlapParams& p) {
  v.number("spread", p.spread, 0, 1e4, "triangles", "side of the cube in which the centroids lie; 0: all in one point");
  v.integer("triangles", p.triangles, 100, 5'000'000, "triangles", "of one metre");
}

Scene make_overlap(const OverlapParams& params) {  // a ray meets as many boxes as overlap
  return heap("builtin:overlap", scattered(params.triangles, params.spread, 1, 1), 1 + params.spread);
}

}  // namespace

std::vector<BuiltinScene> heap_scenes() {
  return {with_params<make_coincident>("coincident", "a ball, copied into its place"),
          with_params<make_slivers>("slivers", "triangles as long and narrow as asked for"),
          with_params<make_overlap>("overlap", "triangles as near to each other as asked for")};
}

}  // namespace etendue
