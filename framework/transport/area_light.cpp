#include "framework/transport/area_light.h"

#include "framework/core/elementary.h"
#include "framework/core/sampling.h"

#include <glm/vector_relational.hpp>

namespace etendue {

namespace {

// 1 - cos of the half angle of the cone a sphere fills, without cancellation; below 0 when the point is inside, or may be on
// the sphere: through one of glass its own inside is seen, and rays start up to 16 clearances off (retreat_of).
float cone_height(const Sphere& sphere, const vec3& position) {
  const float distance2 = length_squared(sphere.centre - position), sin2 = square(sphere.radius) / distance2;
  const float on_sphere = sphere.radius + 24 * clearance_of(position, quadric_extent(sphere));
  return sin2 < 0.9999f && distance2 > square(on_sphere) ? sin2 / (1 + std::sqrt(1 - sin2)) : -1;
}

struct SampleQuadric {
  vec2 u;

  AreaPoint operator()(const Sphere& s) const {
    const vec3 n = sample_unit_sphere(u);
    return {s.centre + s.radius * n, n, 0};
  }
  AreaPoint operator()(const Disk& d) const {
    // A point is uniform over the ring where the square of its radius is uniform.
    const vec2 unit = sample_unit_disk(u);
    const float r2 = glm::dot(unit, unit);
    const float inner2 = square(d.inner_radius), radius = std::sqrt(inner2 + r2 * (square(d.radius) - inner2));
    const vec2 p = r2 > 0 ? unit * (radius / std::sqrt(r2)) : vec2(radius, 0);
    const Frame frame = Frame::from_normal(d.normal);
    return {d.centre + p.x * frame.tangent + p.y * frame.bitangent, d.normal, 0};
  }
  AreaPoint operator()(const Cylinder& c) const {
    const float tube = 2 * c.length, caps = c.caps ? 2 * c.radius : 0;  // areas over pi r
    const Frame frame = Frame::from_normal(c.axis);
    float pick = u.x * (tube + caps);
    if (pick < tube) {
      const float phi = 2 * pi * u.y;
      const vec3 n = math::cos(phi) * frame.tangent + math::sin(phi) * frame.bitangent;
      return {c.base + (pick / tube * c.length) * c.axis + c.radius * n, n, 0};
    }
    pick = (pick - tube) / caps;
    const bool top = pick < 0.5f;
    return (*this)(Disk{c.base + (top ? c.length : 0.0f) * c.axis, c.radius, top ? c.axis : -c.axis},
                   {2 * pick - (top ? 0.0f : 1.0f), u.y});
  }

 private:
  AreaPoint operator()(const Disk& d, const vec2& rescaled) const { return SampleQuadric{rescaled}(d); }
};

}  // namespace

AreaEmitter::AreaEmitter(const Scene& scene, const AreaLight& light)
    : scene_(&scene), primitive_(light.primitive), texture_(light.texture), two_sided_(light.two_sided) {
  const Object& world = scene.objects[0];
  const Geometry& g = world.geometry;
  const Shape& shape = world.shape(primitive_);
  flip_normal_ = shape.flip_normal;
  has_normals_ = shape.has_normals;
  if (g.is_triangle(primitive_)) {
    const uvec3 v = g.triangles[primitive_];
    triangle_ = TrianglePlane(g.positions[v.x], g.positions[v.y], g.positions[v.z]);
    if (flip_normal_) triangle_.normal = -triangle_.normal;
    area_ = 0.5f * triangle_.doubled;
    if (has_normals_) settle_side(world, v);
  } else {
    quadric_ = &g.quadric(primitive_);
    const bool only_outside = shape.mask == no_id || (!two_sided_ && !flip_normal_);  // else its inside is seen through it
    sphere_ = only_outside ? std::get_if<Sphere>(quadric_) : nullptr;
    area_ = quadric_area(*quadric_);
  }
}

// Where the normals at all corners are on one side, so are those between them: the side that emits is the same at each point.
void AreaEmitter::settle_side(const Object& world, const uvec3& corners) {
  const auto along = [&](std::uint32_t i) { return glm::dot(world.normals[i], triangle_.normal); };
  const vec3 sides(along(corners.x), along(corners.y), along(corners.z));
  const vec3 least(0.01f);  // of unit normals: rounding turns none of these round
  const bool front = glm::all(glm::greaterThan(sides, least)), back = glm::all(glm::lessThan(sides, -least));
  if (back) triangle_.normal = -triangle_.normal;
  has_normals_ = !front && !back;
}

std::optional<vec3> AreaEmitter::normal() const {
  if (!quadric_) return has_normals_ ? std::nullopt : std::optional(triangle_.normal);
  const auto* disk = std::get_if<Disk>(quadric_);
  return disk ? std::optional(flip_normal_ ? -disk->normal : disk->normal) : std::nullopt;
}

AreaPoint AreaEmitter::sample(const vec2& u) const {
  if (quadric_) {
    AreaPoint point = std::visit(SampleQuadric{u}, *quadric_);
    if (flip_normal_) point.normal = -point.normal;
    point.clearance = clearance_of(point.position, quadric_extent(*quadric_));
    return point;
  }
  const vec2 b = sample_triangle(u);
  const TrianglePoint p = point_of(triangle_, b);
  if (!has_normals_) return {p.position, triangle_.normal, p.clearance};
  const Hit hit{.t = 0, .uv = b, .instance = 0, .primitive = primitive_};
  return {p.position, scene_->surface_at(Ray{}, hit).normal, p.clearance};  // at each point the side that a ray would see
}

Rgb AreaEmitter::image_at(const vec2& u) const {
  if (texture_ == no_id) return Rgb(1);
  const Object& world = scene_->objects[0];
  const uvec3 v = world.geometry.triangles[primitive_];
  const vec2 b = sample_triangle(u), uv = (1 - b.x - b.y) * world.uvs[v.x] + b.x * world.uvs[v.y] + b.y * world.uvs[v.z];
  return evaluate(scene_->textures[texture_], uv);
}

// Over 16 x 16 points.
Rgb AreaEmitter::mean_of_image() const {
  if (texture_ == no_id) return Rgb(1);
  constexpr int side = 16;
  Rgb sum(0);
  for (int i = 0; i < side * side; ++i) sum += image_at((vec2(i % side, i / side) + 0.5f) / static_cast<float>(side));
  return sum / static_cast<float>(side * side);
}

AreaSample AreaEmitter::sample_towards(const vec3& position, const vec2& u) const {
  if (sphere_) {
    const float height = cone_height(*sphere_, position);
    if (height > 0) {
      if (flip_normal_ && !two_sided_) return {};
      const vec3 axis = sphere_->centre - position;
      const float distance = glm::length(axis);
      const vec3 local = sample_cone(u, height);
      const float across2 = square(distance) * (local.x * local.x + local.y * local.y);
      const float along = distance * local.z;
      const vec3 wi = Frame::from_normal(axis / distance).to_world(local);
      const float reach = along - safe_sqrt(square(sphere_->radius) - across2);
      const vec3 outward = (reach * wi - axis) / sphere_->radius, on_sphere = sphere_->centre + sphere_->radius * outward;
      const float clearance = clearance_of(on_sphere, quadric_extent(*sphere_)) + clearance_from_afar(reach);
      return {wi, reach, 1 / (2 * pi * height), flip_normal_ ? -outward : outward, on_sphere + clearance * outward};
    }
  }
  const AreaPoint p = sample(u);
  return seen_from<float>(position, p.position, p.normal, p.clearance, area_, two_sided_);
}

float AreaEmitter::pdf_towards(const vec3& position, const vec3& wi, const SurfacePoint& point) const {
  if (sphere_) {
    const float height = cone_height(*sphere_, position);
    if (height > 0) return 1 / (2 * pi * height);
  }
  const float cosine = std::abs(glm::dot(wi, point.normal));
  return area_ > 0 && cosine > 0 ? length_squared(point.position - position) / (cosine * area_) : 0;
}

}  // namespace etendue
