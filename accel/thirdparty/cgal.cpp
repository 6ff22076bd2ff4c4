// CGAL takes 10 s and much memory to compile: this file and collapse.cpp alone include it.
#include "accel/thirdparty/cgal.h"

#include "accel/kernels/queries.h"

// CGAL's own checks stay out of Debug builds too: what is degenerate to its rounding need not be to ours, and would throw.
#define CGAL_NDEBUG
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <optional>

namespace etendue {

static_assert(RayStructure<Cgal>);

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;

Point to_point(const dvec3& p) { return {p.x, p.y, p.z}; }

struct Source {
  const Geometry* geometry;
  std::uint32_t id;
};

// A triangle of the tree: made from our geometry whenever CGAL asks for it.
class Triangle {
 public:
  using Id = std::uint32_t;
  using Point = etendue::Point;
  using Datum = Kernel::Triangle_3;
  using Datum_reference = Datum;

  Triangle() = default;
  explicit Triangle(std::vector<Source>::const_iterator source) : source_(*source) {}

  const Id& id() const { return source_.id; }
  dvec3 vertex(int i) const {
    const Geometry& g = *source_.geometry;
    return g.positions[g.triangles[source_.id][i]];
  }
  Point reference_point() const { return to_point(vertex(0)); }
  Datum datum() const { return {to_point(vertex(0)), to_point(vertex(1)), to_point(vertex(2))}; }

 private:
  Source source_{};
};

using Traits = CGAL::AABB_traits<Kernel, Triangle>;
using Tree = CGAL::AABB_tree<Traits>;

struct Met {
  double t;
  vec2 uv;
};

// The point where the ray meets the triangle's plane, by its weights; nothing outside (t_min, t_max].
std::optional<Met> meet_plane(const Geometry& geometry, std::uint32_t id, const Ray& ray) {
  const uvec3 v = geometry.triangles[id];
  const dvec3 p0(geometry.positions[v.x]), e1 = dvec3(geometry.positions[v.y]) - p0, e2 = dvec3(geometry.positions[v.z]) - p0;
  const dvec3 origin(ray.origin), direction(ray.direction), normal = glm::cross(e1, e2);
  const double t = glm::dot(p0 - origin, normal) / glm::dot(direction, normal);
  const auto t_float = static_cast<float>(t);
  if (!(t_float > ray.t_min && t_float <= ray.t_max && t_float < infinity))
    return std::nullopt;  // parallel rays divide by zero
  const dvec3 p = origin + t * direction - p0;
  const double area = glm::dot(normal, normal);
  return Met{t, vec2(glm::dot(glm::cross(p, e2), normal) / area, glm::dot(glm::cross(e1, p), normal) / area)};
}

double largest(const dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// CGAL keeps a ray as two points: the second lies as far from the first as what it may meet, whatever the direction's length.
Point second_point(const Ray& ray, double reach) {
  const dvec3 origin(ray.origin), direction(ray.direction);
  return to_point(origin + direction * (std::max(reach, largest(origin)) / largest(direction)));
}

// A traversal of CGAL's tree that ends with the first triangle met within (t_min, t_max].
template <class Query, class Count>
class AnyHit {
 public:
  AnyHit(const Traits& traits, const Geometry& geometry, const Ray& ray, Count& count)
      : traits_(traits), geometry_(geometry), ray_(ray), count_(count) {}

  bool found() const { return found_; }
  bool go_further() const { return !found_; }
  void intersection(const Query& query, const Triangle& triangle) {
    count_.primitives(1);
    found_ = found_ || (traits_.do_intersect_object()(query, triangle) && meet_plane(geometry_, triangle.id(), ray_));
  }
  template <class Node>
  bool do_intersect(const Query& query, const Node& node) const {
    return traits_.do_intersect_object()(query, node.bbox());
  }

 private:
  const Traits& traits_;
  const Geometry& geometry_;
  const Ray& ray_;
  Count& count_;
  bool found_ = false;
};

}  // namespace

struct Cgal::State {
  const Geometry& geometry;
  Tree tree;
  std::vector<std::uint32_t> quadrics;
  double reach = 0;  // the largest coordinate, metres

  explicit State(const Geometry& g) : geometry(g) {
    std::vector<Source> triangles;
    for (const std::uint32_t id : g.valid_primitives())
      if (g.is_triangle(id)) {
        triangles.push_back({&g, id});
        for (const std::uint32_t v : {g.triangles[id].x, g.triangles[id].y, g.triangles[id].z})
          reach = std::max(reach, largest(g.positions[v]));
      } else {
        quadrics.push_back(id);
      }
    tree.do_not_accelerate_distance_queries();
    tree.insert(triangles.cbegin(), triangles.cend());
    tree.build();
  }

  template <class Count>
  Hit closest(const Ray& ray, Count count) const {
    if (!is_traceable(ray)) return {};
    Hit hit;
    hit.t = ray.t_max;
    const Kernel::Ray_3 query(to_point(ray.origin), second_point(ray, reach));
    // CGAL finds what a whole ray meets first by itself, unless that is met where the ray begins.
    const auto first = [&](bool is_whole) {
      return tree.first_intersected_primitive(query, [&](std::uint32_t id) {
        count.primitives(1);
        return !is_whole && !meet_plane(geometry, id, ray);
      });
    };
    const bool is_whole = ray.t_min == 0 && ray.t_max == infinity;
    auto id = first(is_whole);
    if (id && is_whole && !meet_plane(geometry, *id, ray)) id = first(false);
    if (id)  // CGAL asks nothing more where there is one triangle alone
      if (const auto met = meet_plane(geometry, *id, ray)) hit = {static_cast<float>(met->t), met->uv, 0, *id};
    const TriangleRay shear(ray.direction);
    count.primitives(static_cast<std::uint32_t>(quadrics.size()));
    for (const std::uint32_t id : quadrics)
      if (intersect_primitive(geometry, id, ray, shear, hit)) hit.instance = 0;
    return hit ? hit : Hit{};
  }

  template <class Count>
  bool occluded(const Ray& ray, Count count) const {
    if (!is_traceable(ray)) return false;
    for (const std::uint32_t id : quadrics) {
      count.primitives(1);
      float t;
      vec2 uv;
      if (intersect_quadric(ray, geometry.quadric(id), ray.t_max, t, uv)) return true;
    }
    if (ray.t_max == infinity) return any(Kernel::Ray_3(to_point(ray.origin), second_point(ray, reach)), ray, count);
    const dvec3 end = dvec3(ray.origin) + static_cast<double>(ray.t_max) * dvec3(ray.direction);
    return any(Kernel::Segment_3(to_point(ray.origin), to_point(end)), ray, count);
  }

  template <class Query, class Count>
  bool any(const Query& query, const Ray& ray, Count& count) const {
    AnyHit<Query, Count> walk(tree.traits(), geometry, ray, count);
    tree.traversal(query, walk);
    return walk.found();
  }
};

Cgal::Cgal(const Geometry& geometry) : state_(std::make_shared<const State>(geometry)) {}

Hit Cgal::closest(const Ray& ray) const { return state_->closest(ray, CountNothing{}); }
bool Cgal::occluded(const Ray& ray) const { return state_->occluded(ray, CountNothing{}); }
Hit Cgal::closest_counted(const Ray& ray, TraversalCounters& counters) const {
  return state_->closest(ray, CountWork{counters});
}
bool Cgal::occluded_counted(const Ray& ray, TraversalCounters& counters) const {
  return state_->occluded(ray, CountWork{counters});
}

RayStructureStats Cgal::stats() const {
  const std::uint64_t triangles = state_->tree.size(), nodes = triangles > 1 ? triangles - 1 : 0;
  std::uint64_t depth = 0;  // CGAL halves its triangles
  while (1ull << depth < triangles) ++depth;
  return {
      nodes * sizeof(CGAL::AABB_node<Traits>) + triangles * sizeof(Triangle) + state_->quadrics.size() * sizeof(std::uint32_t),
      nodes, depth, triangles + state_->quadrics.size(), 0};
}

}  // namespace etendue
