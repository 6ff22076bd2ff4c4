#include "accel/exact/exact.h"

#include "accel/bvh/build/binned_sah.h"
#include "accel/exact/exact_primitives.h"
#include "accel/kernels/primitive_test.h"
#include "accel/scene/two_level.h"
#include "framework/core/elementary.h"

namespace etendue {

namespace {

constexpr double distance_tolerance = 1e-5, quadric_rim = 1e-5;
constexpr float end_tolerance = 1e-4f;

// The nearest of what is offered.
struct Nearest {
  const ExactRay& world;
  double t;  // of the best, or where the ray ends
  std::optional<ExactHit> hit;

  explicit Nearest(const ExactRay& ray) : world(ray), t(ray.t_max) {}
  void offer(const std::optional<ExactCrossing>& crossing, const ExactLocalRay& local, std::uint32_t instance,
             std::uint32_t primitive) {
    if (!crossing || (hit && crossing->t >= t)) return;
    t = crossing->t;
    hit = ExactHit{crossing->t, instance, primitive, local.cos_surface(*crossing, world)};
  }
  void offer_planes(const Scene& scene) {
    const ExactLocalRay local(Transform(), world);
    for (std::uint32_t i = 0; i < scene.planes.size(); ++i) offer(cross(scene.planes[i], world), local, plane_instance, i);
  }
};

// Is the point that an answer gives on the primitive that it names, within `slack` (a length)?
bool lies_on_named(const Scene& scene, const ExactRay& ray, const Hit& answer, double slack) {
  const auto agrees = [&](const std::optional<ExactCrossing>& crossing, const ExactLocalRay& local) {
    return crossing &&
           std::abs(answer.t - crossing->t) * local.cos_surface(*crossing, ray) * glm::length(ray.direction) <= slack;
  };
  if (answer.instance == plane_instance)
    return agrees(cross(scene.planes[answer.primitive], ray), ExactLocalRay(Transform(), ray));
  const Instance& instance = scene.instances[answer.instance];
  const Geometry& geometry = scene.objects[instance.object].geometry;
  const ExactLocalRay local(instance.to_world, ray);
  if (geometry.is_triangle(answer.primitive)) {
    const uvec3 v = geometry.triangles[answer.primitive];
    const auto corner = [&](int i) { return local.world(geometry.positions[v[i]]); };
    return distance_to_triangle(ray.at(answer.t), corner(0), corner(1), corner(2)) <= slack;
  }
  return agrees(cross(geometry, answer.primitive, local, 0), local) ||
         agrees(cross(geometry, answer.primitive, local, quadric_rim), local);
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
    const ExactLocalRay local(scene.instances[i].to_world, world);
    const Geometry& geometry = scene.objects[scene.instances[i].object].geometry;
    for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id)
      if (geometry.is_valid(id)) nearest.offer(cross(geometry, id, local, 0), local, i, id);
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
    const ExactLocalRay local(instance.to_world, ray);
    const Geometry& geometry = scene_.objects[instance.object].geometry;
    traverse(bottoms_[instance.object], local.ray, nearest.t,
             [&](std::uint32_t id) { nearest.offer(cross(geometry, id, local, 0), local, i, id); });
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
  const ExactLocalRay local(instance.to_world, ray);
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
    if (const double angle = 0.25 * pi * i; holds_moved(math::cos(angle), math::sin(angle), 0)) return true;
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
