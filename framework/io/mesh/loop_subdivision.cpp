#include "framework/io/mesh/loop_subdivision.h"

#include "framework/core/error.h"
#include "framework/core/fuzzing.h"
#include "framework/core/memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace etendue {

namespace {

constexpr std::size_t bytes_of_triangle = 200;  // with its edges, while the next level is made of it
constexpr std::size_t most_triangles = unless_fuzzed(std::size_t{1} << 26, std::size_t{1} << 10);

struct Edge {
  std::uint32_t low = 0, high = 0;     // the vertices at its ends
  std::uint32_t opposite[2] = {0, 0};  // those across the one or two faces
  int faces = 0;
};

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

// Vertices and faces with what subdivision asks about their neighbours.
class Surface {
 public:
  Surface(const std::vector<vec3>& positions, const std::vector<uvec3>& triangles)
      : positions_(positions), triangles_(triangles), boundary_(positions.size(), false) {
    for (const uvec3& t : triangles)
      for (int i = 0; i < 3; ++i) add_edge(t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
    make_rings();
  }

  const std::vector<Edge>& edges() const { return edges_; }
  std::uint32_t edge_between(std::uint32_t a, std::uint32_t b) const { return edge_of_.at(edge_key(a, b)); }

  vec3 even_vertex(std::uint32_t v) const {
    return boundary_[v] ? on_boundary(v, 1.0f / 8) : within(v, beta(static_cast<int>(valence(v))));
  }
  vec3 odd_vertex(const Edge& e) const {
    const vec3 ends = positions_[e.low] + positions_[e.high];
    if (e.faces == 1) return 0.5f * ends;
    return 0.375f * ends + 0.125f * (positions_[e.opposite[0]] + positions_[e.opposite[1]]);
  }
  vec3 limit(std::uint32_t v) const {
    const auto n = static_cast<int>(valence(v));
    return boundary_[v] ? on_boundary(v, 1.0f / 5) : within(v, 1 / (static_cast<float>(n) + 3 / (8 * beta(n))));
  }
  // Sums of the normals of the faces around each vertex, weighted by area.
  std::vector<vec3> face_normals() const {
    std::vector<vec3> normals(positions_.size(), vec3(0));
    for (const uvec3& t : triangles_) {
      const vec3 n = glm::cross(positions_[t.y] - positions_[t.x], positions_[t.z] - positions_[t.x]);
      for (int i = 0; i < 3; ++i) normals[t[i]] += n;
    }
    return normals;
  }

 private:
  static float beta(int valence) { return valence == 3 ? 3.0f / 16 : 3.0f / (8 * static_cast<float>(valence)); }
  std::uint32_t valence(std::uint32_t v) const { return ring_begin_[v + 1] - ring_begin_[v]; }

  void add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t across) {
    const auto [found, is_new] = edge_of_.try_emplace(edge_key(a, b), static_cast<std::uint32_t>(edges_.size()));
    if (is_new) edges_.push_back({std::min(a, b), std::max(a, b), {across, across}, 0});
    Edge& edge = edges_[found->second];
    if (edge.faces == 2) throw Error(fmt::format("the edge between the vertices {} and {} has more than two faces", a, b));
    edge.opposite[edge.faces++] = across;
  }
  // The neighbours of each vertex; of a boundary's, those along the boundary alone.
  void make_rings() {
    for (const Edge& e : edges_)
      if (e.faces == 1) boundary_[e.low] = boundary_[e.high] = true;
    ring_begin_.assign(positions_.size() + 1, 0);
    const auto in_ring = [&](const Edge& e, std::uint32_t v) { return !boundary_[v] || e.faces == 1; };
    for (const Edge& e : edges_)
      for (const std::uint32_t v : {e.low, e.high}) ring_begin_[v + 1] += in_ring(e, v);
    for (std::size_t v = 0; v < positions_.size(); ++v) ring_begin_[v + 1] += ring_begin_[v];
    ring_.resize(ring_begin_.back());
    std::vector<std::uint32_t> next(ring_begin_.begin(), ring_begin_.end() - 1);
    for (const Edge& e : edges_)
      for (const std::uint32_t v : {e.low, e.high})
        if (in_ring(e, v)) ring_[next[v]++] = v == e.low ? e.high : e.low;
  }
  vec3 ring_sum(std::uint32_t v) const {
    vec3 sum(0);
    for (std::uint32_t i = ring_begin_[v]; i < ring_begin_[v + 1]; ++i) sum += positions_[ring_[i]];
    return sum;
  }
  vec3 within(std::uint32_t v, float weight) const {
    if (valence(v) == 0) return positions_[v];
    return (1 - static_cast<float>(valence(v)) * weight) * positions_[v] + weight * ring_sum(v);
  }
  // A vertex where more than two boundary edges meet stays where it is.
  vec3 on_boundary(std::uint32_t v, float weight) const {
    return valence(v) == 2 ? (1 - 2 * weight) * positions_[v] + weight * ring_sum(v) : positions_[v];
  }

  const std::vector<vec3>& positions_;
  const std::vector<uvec3>& triangles_;
  std::vector<Edge> edges_;
  std::unordered_map<std::uint64_t, std::uint32_t> edge_of_;
  std::vector<bool> boundary_;
  std::vector<std::uint32_t> ring_begin_, ring_;
};

void split(std::vector<vec3>& positions, std::vector<uvec3>& triangles) {
  const Surface surface(positions, triangles);
  const auto before = static_cast<std::uint32_t>(positions.size());
  std::vector<vec3> next_positions;
  next_positions.reserve(before + surface.edges().size());
  for (std::uint32_t v = 0; v < before; ++v) next_positions.push_back(surface.even_vertex(v));
  for (const Edge& e : surface.edges()) next_positions.push_back(surface.odd_vertex(e));
  std::vector<uvec3> next_triangles;
  next_triangles.reserve(4 * triangles.size());
  for (const uvec3& t : triangles) {
    uvec3 m(0);  // the new vertices across from x, y and z
    for (int i = 0; i < 3; ++i) m[i] = before + surface.edge_between(t[(i + 1) % 3], t[(i + 2) % 3]);
    next_triangles.insert(next_triangles.end(), {{t.x, m.z, m.y}, {t.y, m.x, m.z}, {t.z, m.y, m.x}, m});
  }
  positions = std::move(next_positions);
  triangles = std::move(next_triangles);
}

}  // namespace

TriangleMesh subdivide(const TriangleMesh& control, int levels) {
  TriangleMesh mesh{.positions = control.positions, .normals = {}, .uvs = {}, .triangles = {}, .warnings = {}};
  for (const uvec3& t : control.triangles)
    if (t.x != t.y && t.y != t.z && t.z != t.x) mesh.triangles.push_back(t);
  for (int i = 0; i < levels; ++i) {
    if (4 * mesh.triangles.size() > most_triangles)
      throw Error(fmt::format("{} levels make more than {} triangles", levels, most_triangles));
    if (mesh.triangles.size() > (1 << 18))
      require_memory(static_cast<double>(4 * bytes_of_triangle * mesh.triangles.size()), {}, "the subdivided mesh",
                     "fewer levels");
    split(mesh.positions, mesh.triangles);
  }
  const Surface surface(mesh.positions, mesh.triangles);
  std::vector<vec3> limits(mesh.positions.size());
  for (std::uint32_t v = 0; v < limits.size(); ++v) limits[v] = surface.limit(v);
  mesh.positions = std::move(limits);
  mesh.normals = surface.face_normals();  // of the limit, to which `positions_` refers
  for (vec3& n : mesh.normals) n = -n;
  return mesh;
}

}  // namespace etendue
