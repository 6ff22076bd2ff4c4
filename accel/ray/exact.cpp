#include "accel/ray/exact.h"

#include "accel/ray/build_binned_sah.h"
#include "accel/ray/two_level.h"
#include "framework/core/rng.h"
#include "framework/scene/intersect.h"

#include <glm/gtc/matrix_access.hpp>

#include <array>
#include <bit>

namespace etendue {

// Where single precision may put the vertices of a mesh. It rounds each by itself, so a vertex lies at one place for all the
// triangles that have it. Lengths are spread over powers of two: a crack beside a vertex opens where that moves less than what
// lies farther along.
struct VertexRounding {
  double distance = 0;  // along each axis, at most
  std::uint64_t key = 0;

  dvec3 at(const vec3& p) const {
    const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(p + 0.0f);
    std::uint64_t h = hash_keys(key, bits[0], bits[1], bits[2]);
    const double most = std::ldexp(distance, -static_cast<int>(h >> 60));
    dvec3 move;
    for (int axis = 0; axis < 3; ++axis, h = mix_bits(h))
      move[axis] = most * (2.0 * to_unit_float(static_cast<std::uint32_t>(h)) - 1);
    return move;
  }
};

struct ExactRay {
  dvec3 origin, direction;
  double t_min, t_max;
  VertexRounding rounding;
  dvec3 box_slack{0};  // by which the vertices may lie outside their boxes

  explicit ExactRay(const Ray& ray) : origin(ray.origin), direction(ray.direction), t_min(ray.t_min), t_max(ray.t_max) {}
  dvec3 at(double t) const { return origin + t * direction; }
  bool in_range(double t) const { return t > t_min && t <= t_max; }
};

namespace {

constexpr double distance_tolerance = 1e-5, quadric_rim = 1e-5;
constexpr float end_tolerance = 1e-4f;

struct Met {
  double t;
  dvec3 normal;  // not normalised
};

// `rim`: how far outside, in barycentric weight, still counts as inside.
std::optional<Met> meet_triangle(const ExactRay& ray, const dvec3& p0, const dvec3& p1, const dvec3& p2, double rim) {
  const dvec3 a = p0 - ray.origin, b = p1 - ray.origin, c = p2 - ray.origin;
  const double u = glm::dot(glm::cross(c, b), ray.direction), v = glm::dot(glm::cross(a, c), ray.direction),
               w = glm::dot(glm::cross(b, a), ray.direction);
  const double sum = u + v + w, sign = sum < 0 ? -1 : 1;
  if (sum == 0 || std::min({sign * u, sign * v, sign * w}) < -rim * sign * sum) return std::nullopt;
  const dvec3 normal = glm::cross(p1 - p0, p2 - p0);
  const double t = glm::dot(a, normal) / glm::dot(ray.direction, normal);
  if (!ray.in_range(t)) return std::nullopt;
  return Met{t, normal};
}

// The two roots of |o + t d| = radius, in order; none where the line passes by.
std::optional<dvec2> roots(const dvec3& o, const dvec3& d, double radius) {
  const double a = glm::dot(d, d), b = -glm::dot(o, d);
  if (a == 0) return std::nullopt;
  const dvec3 remainder = o + (b / a) * d;
  const double discriminant = radius * radius - glm::dot(remainder, remainder);
  if (discriminant < 0) return std::nullopt;
  const double half = std::sqrt(discriminant / a);
  return dvec2(b / a - half, b / a + half);
}

struct MeetQuadric {
  const ExactRay& ray;
  double rim;
  std::optional<Met> nearest;

  void offer(double t, const dvec3& normal) {
    if (ray.in_range(t) && (!nearest || t < nearest->t)) nearest = Met{t, normal};
  }
  void operator()(const Sphere& s) {
    const dvec3 centre(s.centre);
    const double radius = s.radius * (1 + rim);
    if (const auto t = roots(ray.origin - centre, ray.direction, radius))
      for (int i = 0; i < 2; ++i) offer((*t)[i], ray.at((*t)[i]) - centre);
  }
  void operator()(const Disk& d) { disk(dvec3(d.centre), dvec3(d.normal), d.radius, d.inner_radius); }
  void operator()(const Cylinder& c) {
    const dvec3 axis = glm::normalize(dvec3(c.axis)), base(c.base), o = ray.origin - base;
    const auto across = [&](const dvec3& v) { return v - glm::dot(v, axis) * axis; };
    if (const auto t = roots(across(o), across(ray.direction), c.radius * (1 + rim)))
      for (int i = 0; i < 2; ++i) {
        const dvec3 p = ray.at((*t)[i]) - base;
        const double height = glm::dot(p, axis), slack = rim * c.length;
        if (height >= -slack && height <= c.length + slack) offer((*t)[i], across(p));
      }
    if (!c.caps) return;
    disk(base, axis, c.radius, 0);
    disk(base + static_cast<double>(c.length) * axis, axis, c.radius, 0);
  }
  void disk(const dvec3& centre, const dvec3& normal, double radius, double inner_radius) {
    const double cosine = glm::dot(ray.direction, normal);
    if (cosine == 0) return;
    const double t = glm::dot(centre - ray.origin, normal) / cosine, distance = glm::length(ray.at(t) - centre);
    if (distance <= radius * (1 + rim) && distance >= inner_radius * (1 - rim)) offer(t, normal);
  }
};

std::optional<Met> meet(const InfinitePlane& plane, const ExactRay& ray) {
  const dvec3 normal(plane.normal);
  const double t = glm::dot(dvec3(plane.point) - ray.origin, normal) / glm::dot(ray.direction, normal);
  if (!ray.in_range(t) || !std::isfinite(t)) return std::nullopt;
  return Met{t, normal};
}

// A ray in an instance's space, with the way back.
struct LocalRay {
  ExactRay ray;
  glm::dmat3 to_local{1}, to_world{1};
  dvec3 offset{0};

  LocalRay(const Transform& transform, const ExactRay& r) : ray(r) {
    if (transform.is_identity()) return;
    to_world =
        glm::dmat3(dvec3(transform.vector({1, 0, 0})), dvec3(transform.vector({0, 1, 0})), dvec3(transform.vector({0, 0, 1})));
    offset = transform.point(vec3(0));
    to_local = glm::inverse(to_world);
    ray.origin = to_local * (ray.origin - offset);
    ray.direction = to_local * ray.direction;
    for (int axis = 0; axis < 3; ++axis) {
      const dvec3 row = glm::abs(glm::row(to_local, axis));
      ray.box_slack[axis] = ray.rounding.distance * (row.x + row.y + row.z);
    }
  }
  dvec3 vertex(const vec3& p) const { return ray.rounding.distance > 0 ? dvec3(p) + to_local * ray.rounding.at(p) : dvec3(p); }
  dvec3 world(const vec3& p) const { return to_world * dvec3(p) + offset; }
  double cos_surface(const Met& met, const ExactRay& world_ray) const {
    return std::abs(glm::dot(glm::normalize(world_ray.direction), glm::normalize(met.normal * to_local)));
  }
};

std::optional<Met> meet(const Geometry& geometry, std::uint32_t primitive, const LocalRay& local, double rim) {
  if (geometry.is_triangle(primitive)) {
    const uvec3 v = geometry.triangles[primitive];
    const auto& p = geometry.positions;
    return meet_triangle(local.ray, local.vertex(p[v.x]), local.vertex(p[v.y]), local.vertex(p[v.z]), rim);
  }
  MeetQuadric visitor{local.ray, rim, {}};
  std::visit(visitor, geometry.quadric(primitive));
  return visitor.nearest;
}

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 ab = b - a;
  const double square = glm::dot(ab, ab), t = square > 0 ? std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : 0;
  return glm::distance(p, a + t * ab);
}

double distance_to_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 normal = glm::cross(b - a, c - a);
  const auto inside = [&](const dvec3& from, const dvec3& to) {
    return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(glm::dot(p - a, glm::normalize(normal)));
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

// The nearest of what is offered.
struct Nearest {
  const ExactRay& world;
  double t;  // of the best, or where the ray ends
  std::optional<ExactHit> hit;

  explicit Nearest(const ExactRay& ray) : world(ray), t(ray.t_max) {}
  void offer(const std::optional<Met>& met, const LocalRay& local, std::uint32_t instance, std::uint32_t primitive) {
    if (!met || (hit && met->t >= t)) return;
    t = met->t;
    hit = ExactHit{met->t, instance, primitive, local.cos_surface(*met, world)};
  }
  void offer_planes(const Scene& scene) {
    const LocalRay local(Transform(), world);
    for (std::uint32_t i = 0; i < scene.planes.size(); ++i) offer(meet(scene.planes[i], world), local, plane_instance, i);
  }
};

// Is the point that an answer gives on the primitive that it names, within `slack` (a length)?
bool lies_on_named(const Scene& scene, const ExactRay& ray, const Hit& answer, double slack) {
  const auto agrees = [&](const std::optional<Met>& met, const LocalRay& local) {
    return met && std::abs(answer.t - met->t) * local.cos_surface(*met, ray) * glm::length(ray.direction) <= slack;
  };
  if (answer.instance == plane_instance) return agrees(meet(scene.planes[answer.primitive], ray), LocalRay(Transform(), ray));
  const Instance& instance = scene.instances[answer.instance];
  const Geometry& geometry = scene.objects[instance.object].geometry;
  const LocalRay local(instance.to_world, ray);
  if (geometry.is_triangle(answer.primitive)) {
    const uvec3 v = geometry.triangles[answer.primitive];
    const auto corner = [&](int i) { return local.world(geometry.positions[v[i]]); };
    return distance_to_triangle(ray.at(answer.t), corner(0), corner(1), corner(2)) <= slack;
  }
  return agrees(meet(geometry, answer.primitive, local, 0), local) ||
         agrees(meet(geometry, answer.primitive, local, quadric_rim), local);
}

// Is nothing met clearly before the answer's distance?
bool is_first(const ExactRay& ray, const Hit& answer, const std::optional<ExactHit>& exact, double slack) {
  return !exact || (answer.t - exact->t) * exact->cos_surface * glm::length(ray.direction) <= slack;
}

// Does the ray meet the box before t_best? Boxes hold their triangles exactly, and 1e-12 is far above double's rounding.
bool meets_box(const Bounds& box, const ExactRay& ray, double t_best) {
  double entry = ray.t_min, exit = std::min(ray.t_max, t_best);
  for (int axis = 0; axis < 3; ++axis) {
    const double slack = ray.box_slack[axis] +
                         1e-12 * (std::abs(ray.origin[axis]) + std::max(std::abs(box.lower[axis]), std::abs(box.upper[axis])));
    const double lower = box.lower[axis] - slack - ray.origin[axis], upper = box.upper[axis] + slack - ray.origin[axis];
    if (ray.direction[axis] == 0) {
      if (lower > 0 || upper < 0) return false;
      continue;
    }
    const auto [near, far] = std::minmax({lower / ray.direction[axis], upper / ray.direction[axis]});
    entry = std::max(entry, near - 1e-12 * std::abs(near));
    exit = std::min(exit, far + 1e-12 * std::abs(far));
  }
  return entry <= exit;
}

// visit(primitive) for those whose boxes the ray meets; t_best may fall meanwhile.
template <class Visit>
void traverse(const BinaryTree& tree, const ExactRay& ray, const double& t_best, const Visit& visit) {
  if (tree.nodes.empty()) return;
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const TreeNode& node = tree.nodes[stack.back()];
    stack.pop_back();
    if (!meets_box(node.bounds, ray, t_best)) continue;
    if (node.is_leaf()) {
      for (std::uint32_t i = 0; i < node.count; ++i) visit(tree.primitives[node.first + i]);
      continue;
    }
    const TreeNode &a = tree.nodes[node.first], &b = tree.nodes[node.first + 1];
    const bool b_first = glm::dot(dvec3(b.bounds.centre()) - dvec3(a.bounds.centre()), ray.direction) < 0;
    stack.push_back(b_first ? node.first : node.first + 1);
    stack.push_back(b_first ? node.first + 1 : node.first);
  }
}

constexpr double move_tolerance = 0x1p-20;
constexpr std::uint64_t vertex_roundings = 512;  // a crack opens in one of 4 to 100

}  // namespace

std::optional<ExactHit> exact_closest(const Scene& scene, const Ray& ray) {
  if (!is_traceable(ray)) return std::nullopt;
  const ExactRay world(ray);
  Nearest nearest(world);
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const LocalRay local(scene.instances[i].to_world, world);
    const Geometry& geometry = scene.objects[scene.instances[i].object].geometry;
    for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id)
      if (geometry.is_valid(id)) nearest.offer(meet(geometry, id, local, 0), local, i, id);
  }
  nearest.offer_planes(scene);
  return nearest.hit;
}

bool is_right(const Scene& scene, const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact) {
  if (!answer) return !exact;
  const ExactRay world(ray);
  const double slack = distance_tolerance * (glm::length(world.origin) + answer.t * glm::length(world.direction));
  return lies_on_named(scene, world, answer, slack) && is_first(world, answer, exact, slack);
}

bool is_right(const Scene& scene, const Ray& ray, bool occluded) {
  Ray moved = ray;
  moved.t_max *= occluded ? 1 + end_tolerance : 1 - end_tolerance;
  return exact_closest(scene, moved).has_value() == occluded;
}

ExactTracer::ExactTracer(const Scene& scene) : scene_(scene), bounds_(scene.bounds()) {
  for (const Object& object : scene.objects) bottoms_.push_back(build_binned_sah(build_items(object.geometry), {}));
  top_ = build_binned_sah(instance_items(scene), {});
}

std::optional<ExactHit> ExactTracer::closest(const Ray& ray) const {
  return is_traceable(ray) ? closest(ExactRay(ray)) : std::nullopt;
}

std::optional<ExactHit> ExactTracer::closest(const ExactRay& ray) const {
  Nearest nearest(ray);
  traverse(top_, ray, nearest.t, [&](std::uint32_t i) {
    const Instance& instance = scene_.instances[i];
    const LocalRay local(instance.to_world, ray);
    const Geometry& geometry = scene_.objects[instance.object].geometry;
    traverse(bottoms_[instance.object], local.ray, nearest.t,
             [&](std::uint32_t id) { nearest.offer(meet(geometry, id, local, 0), local, i, id); });
  });
  nearest.offer_planes(scene_);
  return nearest.hit;
}

// How far from the ray's origin its arithmetic reaches: to the scene's far end; where the ray is moved into an object's space,
// also to where the origin lies.
double ExactTracer::reach(const ExactRay& ray) const {
  const dvec3 lower = dvec3(bounds_.lower) - ray.origin, upper = dvec3(bounds_.upper) - ray.origin;
  const double far = glm::length(bounds_.empty() ? ray.origin : glm::max(glm::abs(lower), glm::abs(upper)));
  return scene_.has_instances() ? std::max(far, glm::length(ray.origin)) : far;
}

// May a triangle whose vertices move by up to `distance` along each axis lose this hit? Only where the ray passes that near an
// edge.
bool ExactTracer::may_slip(const ExactRay& ray, const ExactHit& hit, double distance) const {
  if (hit.instance == plane_instance) return false;
  const Instance& instance = scene_.instances[hit.instance];
  const Geometry& geometry = scene_.objects[instance.object].geometry;
  if (!geometry.is_triangle(hit.primitive)) return false;
  const LocalRay local(instance.to_world, ray);
  const dvec3 along = glm::normalize(ray.direction);
  dvec3 across[3];
  for (int i = 0; i < 3; ++i) {
    across[i] = local.world(geometry.positions[geometry.triangles[hit.primitive][i]]) - ray.origin;
    across[i] -= glm::dot(across[i], along) * along;
  }
  const auto nears = [&](int i, int j) { return distance_to_segment(dvec3(0), across[i], across[j]) <= 2 * distance; };
  return nears(0, 1) || nears(1, 2) || nears(2, 0);
}

// Whether `holds` of one of the rays that rounding may have made of this one, or of this one in a mesh that it may have made.
// `exact`: what closest(ray) gave.
template <class Holds>
bool ExactTracer::any_moved(const ExactRay& ray, const std::optional<ExactHit>& exact, const Holds& holds) const {
  const double distance = move_tolerance * reach(ray);
  const Frame frame = Frame::from_normal(vec3(glm::normalize(ray.direction)));
  const auto holds_moved = [&](double x, double y, double z) {
    ExactRay moved = ray;
    moved.origin += distance * (x * dvec3(frame.tangent) + y * dvec3(frame.bitangent) + z * dvec3(frame.normal));
    return holds(moved);
  };
  for (int i = 0; i < 8; ++i)
    if (const double angle = 0.25 * pi * i; holds_moved(std::cos(angle), std::sin(angle), 0)) return true;
  if (holds_moved(0, 0, -1) || holds_moved(0, 0, 1)) return true;
  if (exact && !may_slip(ray, *exact, distance)) return false;
  ExactRay rounded = ray;
  rounded.box_slack = dvec3(distance);
  for (std::uint64_t key = 0; key < vertex_roundings; ++key) {
    rounded.rounding = {distance, key};
    if (holds(rounded)) return true;
  }
  return false;
}

bool ExactTracer::is_right(const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact) const {
  if (!is_traceable(ray)) return !answer;
  const ExactRay world(ray);
  if (!answer) return !exact || any_moved(world, exact, [&](const ExactRay& moved) { return !closest(moved); });
  const double slack = distance_tolerance * std::max(reach(world), answer.t * glm::length(world.direction));
  const auto on_named = [&](const ExactRay& r) { return lies_on_named(scene_, r, answer, slack); };
  if (!on_named(world) && !any_moved(world, exact, on_named)) return false;
  return is_first(world, answer, exact, slack) ||
         any_moved(world, exact, [&](const ExactRay& moved) { return is_first(moved, answer, closest(moved), slack); });
}

bool ExactTracer::is_right(const Ray& ray, bool occluded, const std::optional<ExactHit>& exact) const {
  if (exact.has_value() == occluded) return true;
  if (!is_traceable(ray)) return false;
  const auto gives = [&](ExactRay r) {
    r.t_max *= occluded ? 1 + end_tolerance : 1 - end_tolerance;
    return closest(r).has_value() == occluded;
  };
  return gives(ExactRay(ray)) || any_moved(ExactRay(ray), exact, gives);
}

}  // namespace etendue
