#include "framework/transport/area_light.h"

#include "framework/scene/triangle_point.h"
#include "framework/transport/sampling.h"

namespace etendue {

namespace {

const Sphere* sphere_of(const Geometry& geometry, std::uint32_t primitive) {
  return geometry.is_triangle(primitive) ? nullptr : std::get_if<Sphere>(&geometry.quadric(primitive));
}

// 1 - cos of the half angle of the cone a sphere fills, without cancellation; below 0 when the point is inside.
float cone_height(const Sphere& sphere, const vec3& position) {
  const float sin2 = square(sphere.radius) / length_squared(sphere.centre - position);
  return sin2 < 0.9999f ? sin2 / (1 + std::sqrt(1 - sin2)) : -1;
}

struct SampleQuadric {
  vec2 u;

  AreaPoint operator()(const Sphere& s) const {
    const vec3 n = sample_unit_sphere(u);
    return {s.centre + s.radius * n, n, 0, 0};
  }
  AreaPoint operator()(const Disk& d) const {
    // Uniform over the ring: the square of the radius is.
    const vec2 unit = sample_unit_disk(u);
    const float r2 = glm::dot(unit, unit);
    const float inner2 = square(d.inner_radius), radius = std::sqrt(inner2 + r2 * (square(d.radius) - inner2));
    const vec2 p = r2 > 0 ? unit * (radius / std::sqrt(r2)) : vec2(radius, 0);
    const Frame frame = Frame::from_normal(d.normal);
    return {d.centre + p.x * frame.tangent + p.y * frame.bitangent, d.normal, 0, 0};
  }
  AreaPoint operator()(const Cylinder& c) const {
    const float tube = 2 * c.length, caps = c.caps ? 2 * c.radius : 0;  // areas over pi r
    const Frame frame = Frame::from_normal(c.axis);
    float pick = u.x * (tube + caps);
    if (pick < tube) {
      const float phi = 2 * pi * u.y;
      const vec3 n = std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent;
      return {c.base + (pick / tube * c.length) * c.axis + c.radius * n, n, 0, 0};
    }
    pick = (pick - tube) / caps;
    const bool top = pick < 0.5f;
    return (*this)(Disk{c.base + (top ? c.length : 0.0f) * c.axis, c.radius, top ? c.axis : -c.axis},
                   {2 * pick - (top ? 0.0f : 1.0f), u.y});
  }

 private:
  AreaPoint operator()(const Disk& d, const vec2& rescaled) const { return SampleQuadric{rescaled}(d); }
};

TrianglePoint point_of(const Geometry& geometry, std::uint32_t primitive, const vec2& uv) {
  const uvec3 v = geometry.triangles[primitive];
  return triangle_point(geometry.positions[v.x], geometry.positions[v.y], geometry.positions[v.z], uv);
}

AreaPoint sample_triangle_light(const Scene& scene, const Shape& shape, std::uint32_t primitive, const vec2& u) {
  const Geometry& g = scene.objects[0].geometry;
  const vec2 b = sample_triangle(u);
  const TrianglePoint p = point_of(g, primitive, b);
  vec3 normal = shape.flip_normal ? -p.normal : p.normal;
  if (shape.has_normals)  // they tell which side emits, at each point: the one that a ray would see
    normal = scene.surface_at(Ray{}, {.t = 0, .uv = b, .instance = 0, .primitive = primitive}).normal;
  return {p.position, normal, p.clearance, p.area};
}

}  // namespace

float primitive_area(const Geometry& geometry, std::uint32_t primitive) {
  if (!geometry.is_triangle(primitive)) return quadric_area(geometry.quadric(primitive));
  return point_of(geometry, primitive, vec2(0)).area;
}

AreaPoint sample_area(const Scene& scene, const AreaLight& light, const vec2& u) {
  const Object& world = scene.objects[0];
  const Geometry& g = world.geometry;
  const Shape& shape = world.shape(light.primitive);
  if (g.is_triangle(light.primitive)) return sample_triangle_light(scene, shape, light.primitive, u);
  const Quadric& quadric = g.quadric(light.primitive);
  AreaPoint point = std::visit(SampleQuadric{u}, quadric);
  if (shape.flip_normal) point.normal = -point.normal;
  point.clearance = clearance_of(point.position, quadric_extent(quadric));
  point.area = quadric_area(quadric);
  return point;
}

AreaSample sample_area_towards(const Scene& scene, const AreaLight& light, const vec3& position, const vec2& u) {
  const Object& world = scene.objects[0];
  if (const Sphere* sphere = sphere_of(world.geometry, light.primitive)) {
    const float height = cone_height(*sphere, position);
    if (height > 0) {
      if (world.shape(light.primitive).flip_normal && !light.two_sided) return {};
      const vec3 axis = sphere->centre - position;
      const float distance = glm::length(axis);
      const vec3 local = sample_cone(u, 1 - height);
      const float across2 = square(distance) * (local.x * local.x + local.y * local.y);
      const float along = distance * local.z;
      const vec3 wi = Frame::from_normal(axis / distance).to_world(local);
      const float reach = along - safe_sqrt(square(sphere->radius) - across2);
      const float side = world.shape(light.primitive).flip_normal ? -1 : 1;
      const vec3 outward = (reach * wi - axis) / sphere->radius, on_sphere = sphere->centre + sphere->radius * outward;
      const float clearance = clearance_of(on_sphere, quadric_extent(*sphere)) + clearance_from_afar(reach);
      return {wi, reach, 1 / (2 * pi * height), side * outward, on_sphere + clearance * outward};
    }
  }
  const AreaPoint p = sample_area(scene, light, u);
  const vec3 towards = p.position - position;
  const float distance2 = length_squared(towards);
  if (!(distance2 > 0) || !(p.area > 0)) return {};
  const float distance = std::sqrt(distance2);
  const vec3 wi = towards / distance;
  const float cosine = -glm::dot(wi, p.normal);
  if (cosine == 0 || (cosine < 0 && !light.two_sided)) return {};
  const float clearance = std::copysign(p.clearance + clearance_from_afar(distance), cosine);
  return {wi, distance, distance2 / (std::abs(cosine) * p.area), p.normal, p.position + clearance * p.normal};
}

float area_pdf_towards(const Scene& scene, const AreaLight& light, const vec3& position, const vec3& wi,
                       const SurfacePoint& point) {
  const Geometry& g = scene.objects[0].geometry;
  if (const Sphere* sphere = sphere_of(g, light.primitive)) {
    const float height = cone_height(*sphere, position);
    if (height > 0) return 1 / (2 * pi * height);
  }
  const float area = primitive_area(g, light.primitive), cosine = std::abs(glm::dot(wi, point.normal));
  return area > 0 && cosine > 0 ? length_squared(point.position - position) / (cosine * area) : 0;
}

}  // namespace etendue
