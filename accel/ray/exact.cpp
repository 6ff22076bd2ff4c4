#include "accel/ray/exact.h"

#include "framework/scene/intersect.h"

namespace etendue {

namespace {

constexpr double distance_tolerance = 1e-5, triangle_rim = 1e-4, quadric_rim = 1e-5;
constexpr float end_tolerance = 1e-4f;

struct ExactRay {
  dvec3 origin, direction;
  double t_min, t_max;

  dvec3 at(double t) const { return origin + t * direction; }
  bool in_range(double t) const { return t > t_min && t <= t_max; }
};

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

std::optional<Met> meet(const Geometry& geometry, std::uint32_t primitive, const ExactRay& ray, double rim) {
  if (geometry.is_triangle(primitive)) {
    const uvec3 v = geometry.triangles[primitive];
    const auto& p = geometry.positions;
    return meet_triangle(ray, dvec3(p[v.x]), dvec3(p[v.y]), dvec3(p[v.z]), rim);
  }
  MeetQuadric visitor{ray, rim, {}};
  std::visit(visitor, geometry.quadric(primitive));
  return visitor.nearest;
}

std::optional<Met> meet(const InfinitePlane& plane, const ExactRay& ray) {
  const dvec3 normal(plane.normal);
  const double t = glm::dot(dvec3(plane.point) - ray.origin, normal) / glm::dot(ray.direction, normal);
  if (!ray.in_range(t) || !std::isfinite(t)) return std::nullopt;
  return Met{t, normal};
}

// A ray in an instance's space, with the way back for normals.
struct LocalRay {
  ExactRay ray;
  glm::dmat3 to_local{1};

  LocalRay(const Transform& to_world, const Ray& r) : ray{r.origin, r.direction, r.t_min, r.t_max} {
    if (to_world.is_identity()) return;
    const glm::dmat3 linear(dvec3(to_world.vector({1, 0, 0})), dvec3(to_world.vector({0, 1, 0})),
                            dvec3(to_world.vector({0, 0, 1})));
    to_local = glm::inverse(linear);
    ray.origin = to_local * (ray.origin - dvec3(to_world.point(vec3(0))));
    ray.direction = to_local * ray.direction;
  }
  double cos_surface(const Met& met, const Ray& world) const {
    return std::abs(glm::dot(glm::normalize(dvec3(world.direction)), glm::normalize(met.normal * to_local)));
  }
};

// Is the primitive that an answer names met at the distance it gives? First within its rim, then a little outside.
bool meets_named(const Scene& scene, const Ray& ray, const Hit& answer, double slack) {
  const auto agrees = [&](const std::optional<Met>& met, const LocalRay& local) {
    return met && std::abs(answer.t - met->t) * local.cos_surface(*met, ray) <= slack;
  };
  if (answer.instance == plane_instance) {
    const LocalRay world(Transform(), ray);
    return agrees(meet(scene.planes[answer.primitive], world.ray), world);
  }
  const Instance& instance = scene.instances[answer.instance];
  const Geometry& geometry = scene.objects[instance.object].geometry;
  const LocalRay local(instance.to_world, ray);
  const double rim = geometry.is_triangle(answer.primitive) ? triangle_rim : quadric_rim;
  return agrees(meet(geometry, answer.primitive, local.ray, 0), local) ||
         agrees(meet(geometry, answer.primitive, local.ray, rim), local);
}

}  // namespace

std::optional<ExactHit> exact_closest(const Scene& scene, const Ray& ray) {
  if (!is_traceable(ray)) return std::nullopt;
  std::optional<ExactHit> best;
  const auto offer = [&](const std::optional<Met>& met, const LocalRay& local, std::uint32_t instance,
                         std::uint32_t primitive) {
    if (met && (!best || met->t < best->t)) best = ExactHit{met->t, instance, primitive, local.cos_surface(*met, ray)};
  };
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const LocalRay local(scene.instances[i].to_world, ray);
    const Geometry& geometry = scene.objects[scene.instances[i].object].geometry;
    for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id)
      if (geometry.is_valid(id)) offer(meet(geometry, id, local.ray, 0), local, i, id);
  }
  const LocalRay world(Transform(), ray);
  for (std::uint32_t i = 0; i < scene.planes.size(); ++i) offer(meet(scene.planes[i], world.ray), world, plane_instance, i);
  return best;
}

bool is_right(const Scene& scene, const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact) {
  if (!answer) return !exact;
  // Along the surface's normal, in units of t.
  const double slack = distance_tolerance * (glm::length(dvec3(ray.origin)) / glm::length(dvec3(ray.direction)) + answer.t);
  return meets_named(scene, ray, answer, slack) && (!exact || (answer.t - exact->t) * exact->cos_surface <= slack);
}

bool is_right(const Scene& scene, const Ray& ray, bool occluded) {
  Ray moved = ray;
  moved.t_max *= occluded ? 1 + end_tolerance : 1 - end_tolerance;
  return exact_closest(scene, moved).has_value() == occluded;
}

}  // namespace etendue
