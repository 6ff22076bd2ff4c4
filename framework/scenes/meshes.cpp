#include "framework/scenes/meshes.h"

#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"

namespace etendue {

namespace {

// Smooth value noise: eight hashed corners, cubic between.
float noise(const vec3& p) {
  const vec3 cell = glm::floor(p), f = p - cell, s = f * f * (3.0f - 2.0f * f);
  const auto corner = [&](int dx, int dy, int dz) {
    const auto i = [](float c, int d) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(c) + d); };
    std::uint64_t h =
        i(cell.x, dx) * 0x9e3779b97f4a7c15ull ^ i(cell.y, dy) * 0xc2b2ae3d27d4eb4full ^ i(cell.z, dz) * 0x165667b19e3779f9ull;
    h ^= h >> 29;
    h *= 0xbf58476d1ce4e5b9ull;
    return static_cast<float>(h >> 40) * 0x1p-24f;
  };
  const auto edge = [&](int dy, int dz) { return glm::mix(corner(0, dy, dz), corner(1, dy, dz), s.x); };
  return glm::mix(glm::mix(edge(0, 0), edge(1, 0), s.y), glm::mix(edge(0, 1), edge(1, 1), s.y), s.z);
}

// Steps that rise from the edge of the field outwards, 24 of them in 96 sectors: 9,216 triangles. Width 1, about the origin.
MeshData bowl() {
  constexpr std::uint32_t steps = 24, sectors = 96, rings = 2 * steps + 1;
  MeshData mesh;
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    const float radius = 0.25f + 0.25f * static_cast<float>(ring / 2) / steps;
    const float height = 0.15f * static_cast<float>((ring + 1) / 2) / steps;
    for (std::uint32_t sector = 0; sector < sectors; ++sector) {
      const float phi = 2 * pi * static_cast<float>(sector) / sectors;
      mesh.positions.emplace_back(radius * math::cos(phi), height, radius * math::sin(phi));
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < rings; ++ring)
    for (std::uint32_t sector = 0; sector < sectors; ++sector) {
      const std::uint32_t a = ring * sectors + sector, b = ring * sectors + (sector + 1) % sectors;
      mesh.triangles.emplace_back(a, b, a + sectors);
      mesh.triangles.emplace_back(b, b + sectors, a + sectors);
    }
  return mesh;
}

}  // namespace

MeshData rough_ball(const vec3& centre, float radius, int triangles) {
  const double bands = std::max(1.0, std::round(std::sqrt(0.4 * triangles)));  // of two triangles a column
  const auto rows = static_cast<std::uint32_t>(bands) + 1;
  const auto columns = std::max(3u, static_cast<std::uint32_t>(std::lround(0.5 * triangles / bands)));
  MeshData mesh;
  const auto point = [&](const vec3& direction) {
    float height = 0, amplitude = 0.5f, frequency = 2;
    for (int octave = 0; octave < 5; ++octave, amplitude *= 0.5f, frequency *= 2.03f)
      height += amplitude * noise(direction * frequency + 17.0f);
    return centre + radius * (0.7f + 0.5f * height) * direction;
  };
  mesh.positions.push_back(point({0, 1, 0}));
  for (std::uint32_t row = 1; row < rows; ++row) {
    const float theta = pi * static_cast<float>(row) / static_cast<float>(rows);
    for (std::uint32_t column = 0; column < columns; ++column) {
      const float phi = 2 * pi * static_cast<float>(column) / static_cast<float>(columns);
      mesh.positions.push_back(point({math::sin(theta) * math::cos(phi), math::cos(theta), math::sin(theta) * math::sin(phi)}));
    }
  }
  mesh.positions.push_back(point({0, -1, 0}));
  const auto south = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  const auto vertex = [&](std::uint32_t row, std::uint32_t column) { return 1 + (row - 1) * columns + column % columns; };
  for (std::uint32_t c = 0; c < columns; ++c) {
    mesh.triangles.emplace_back(0, vertex(1, c + 1), vertex(1, c));
    for (std::uint32_t r = 1; r + 1 < rows; ++r) {
      mesh.triangles.emplace_back(vertex(r, c), vertex(r, c + 1), vertex(r + 1, c));
      mesh.triangles.emplace_back(vertex(r, c + 1), vertex(r + 1, c + 1), vertex(r + 1, c));
    }
    mesh.triangles.emplace_back(vertex(rows - 1, c), vertex(rows - 1, c + 1), south);
  }
  return mesh;
}

namespace {

// The ball, half a metre across, on the field of a stadium that is `size` times as wide: nearly all triangles lie in a tiny
// part of space.
struct StadiumParams {
  int triangles = 100'000;
  float size = 100;
};

template <class Visitor>
void describe(Visitor& v, StadiumParams& params) {
  v.integer("triangles", params.triangles, 100, 50'000'000, "triangles", "of the ball, to within a percent");
  v.number("size", params.size, 2, 100'000, "balls", "width of the stadium");
}

Scene make_stadium(const StadiumParams& params) {
  SceneBuilder b("builtin:stadium");
  constexpr float radius = 0.25f;
  const float width = 2 * radius * params.size, half = 0.25f * width;
  b.mesh(quad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}),
         b.material(Diffuse{Rgb(0.2f, 0.5f, 0.15f)}));
  b.mesh(transformed(bowl(), Transform::scale(vec3(width))), b.material(Diffuse{Rgb(0.5f)}));
  b.mesh(rough_ball({0, 1.2f * radius, 0}, radius, params.triangles), b.material(Diffuse{Rgb(0.6f, 0.35f, 0.2f)}));
  b.light(EnvironmentLight{.scale = Rgb(0.35f, 0.4f, 0.5f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  b.light(DirectionalLight{.direction = glm::normalize(vec3(0.5f, -1, -0.6f)), .irradiance = Rgb(2)});
  b.camera({0.4f, 0.55f, 1.1f}, {0, 0.3f, 0}, 40, {192, 192});
  return b.finish();
}

}  // namespace

std::vector<BuiltinScene> stadium_scenes() {
  return {with_params<make_stadium>("stadium", "the ball in a stadium: dense in little of a large space")};
}

}  // namespace etendue
