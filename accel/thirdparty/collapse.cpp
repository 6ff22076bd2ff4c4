// Like cgal.cpp, this takes long and much memory to compile.
#include "accel/thirdparty/collapse.h"

#define CGAL_NDEBUG
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace etendue {

namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using FaceTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Mesh> > >;

constexpr std::size_t most_samples = 10'000;  // vertices whose distance is measured

auto coordinates(const vec3& p) { return std::tuple(p.x, p.y, p.z); }

// For each position, the first one at the same place.
std::vector<std::uint32_t> joined(std::span<const vec3> positions) {
  std::vector<std::uint32_t> order(positions.size()), first(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t v) { return std::tuple_cat(coordinates(positions[v]), std::tuple(v)); });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && positions[order[i]] == positions[order[i - 1]] ? first[order[i - 1]] : order[i];
  return first;
}

struct Collapsing {
  Mesh mesh;
  std::vector<uvec3> kept;  // triangles that do not fit into a manifold
  std::vector<vec3> fine;   // vertices that triangles use

  Collapsing(std::span<const vec3> positions, std::span<const uvec3> all) {
    std::vector<vec3> finite(positions.begin(), positions.end());
    for (vec3& p : finite)
      if (!is_finite(p)) p = vec3(0);  // no triangle below uses it
    const std::vector<std::uint32_t> first = joined(finite);
    std::vector<std::uint32_t> vertex(positions.size(), ~0u);
    for (const uvec3& t : all) {
      const uvec3 at(first[t.x], first[t.y], first[t.z]);
      if (at.x == at.y || at.y == at.z || at.z == at.x) continue;
      if (!is_finite(positions[t.x]) || !is_finite(positions[t.y]) || !is_finite(positions[t.z])) continue;
      uvec3 corners;
      for (int i = 0; i < 3; ++i) {
        std::uint32_t& v = vertex[at[i]];
        if (v == ~0u) {
          v = static_cast<std::uint32_t>(fine.size());
          const vec3& p = positions[at[i]];
          fine.push_back(p);
          mesh.add_vertex({p.x, p.y, p.z});
        }
        corners[i] = v;
      }
      using Vertex = Mesh::Vertex_index;
      if (mesh.add_face(Vertex(corners.x), Vertex(corners.y), Vertex(corners.z)) == Mesh::null_face()) kept.push_back(corners);
    }
  }

  void collapse_to(double triangle_count) {
    const double faces = static_cast<double>(mesh.number_of_faces());
    if (faces <= triangle_count) return;
    const auto edges = static_cast<std::size_t>(triangle_count / faces * static_cast<double>(mesh.number_of_edges()));
    simplification::edge_collapse(mesh, simplification::Count_stop_predicate<Mesh>(edges));
  }

  CoarseMesh result() {
    CoarseMesh coarse;
    std::vector<std::uint32_t> number(mesh.num_vertices(), ~0u);  // removed ones too
    for (const Mesh::Vertex_index v : mesh.vertices()) {
      number[v] = static_cast<std::uint32_t>(coarse.positions.size());
      const Kernel::Point_3& p = mesh.point(v);
      coarse.positions.emplace_back(p.x(), p.y(), p.z());
    }
    for (const Mesh::Face_index f : mesh.faces()) {
      uvec3 corners;
      int i = 0;
      for (const Mesh::Vertex_index v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) corners[i++] = number[v];
      coarse.triangles.push_back(corners);
    }
    const auto before = static_cast<std::uint32_t>(coarse.positions.size());
    for (const uvec3& t : kept) {
      const auto at = static_cast<std::uint32_t>(coarse.positions.size());
      for (int i = 0; i < 3; ++i) coarse.positions.push_back(fine[t[i]]);
      coarse.triangles.emplace_back(at, at + 1, at + 2);
    }
    coarse.distance = before == 0 ? 0 : distance();
    return coarse;
  }

 private:
  float distance() const {
    FaceTree tree(faces(mesh).first, faces(mesh).second, mesh);
    tree.accelerate_distance_queries();
    double largest = 0;
    const std::size_t samples = std::min(fine.size(), most_samples);
    for (std::size_t i = 0; i < samples; ++i) {
      const vec3& p = fine[i * fine.size() / samples];
      largest = std::max(largest, tree.squared_distance({p.x, p.y, p.z}));
    }
    return static_cast<float>(std::sqrt(largest));
  }
};

}  // namespace

std::vector<CoarseMesh> collapse_edges(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                       std::span<const double> shares) {
  Collapsing collapsing(positions, triangles);
  const double all = static_cast<double>(collapsing.mesh.number_of_faces());
  std::vector<CoarseMesh> levels;
  for (const double share : shares) {
    collapsing.collapse_to(share * all);
    levels.push_back(collapsing.result());
  }
  return levels;
}

}  // namespace etendue
