#include "framework/scene/scene.h"

#include "framework/core/check.h"
#include "framework/scene/recentre.h"
#include "framework/scene/triangle_point.h"

namespace etendue {

namespace {

struct QuadricPoint {
  vec3 position, normal, shading_normal, tangent;
  vec2 uv;
};

// A point retreats by so many clearances, and by no more than this share of the way it was found by.
constexpr float most_clearances = 16, most_of_way = 0.125f;

vec3 normalised_or(const vec3& v, const vec3& fallback) {
  const float length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : fallback;
}

// dp/du from the texture coordinates of the corners; any perpendicular direction where they are degenerate.
vec3 triangle_tangent(const vec3& e1, const vec3& e2, const vec2& d1, const vec2& d2, const vec3& normal) {
  const float determinant = d1.x * d2.y - d1.y * d2.x;
  if (std::abs(determinant) < 1e-12f) return Frame::from_normal(normal).tangent;
  return (d2.y * e1 - d1.y * e2) / determinant;
}

// Normals and texture coordinates that the file gives.
[[gnu::noinline]] void set_vertex_values(const Object& object, const Shape& shape, const Hit& hit,
                                         const TrianglePlane& triangle, SurfacePoint& s) {
  const uvec3 v = object.geometry.triangles[hit.primitive];
  const float b1 = hit.uv.x, b2 = hit.uv.y, b0 = 1 - b1 - b2;
  if (shape.has_normals) {
    s.shading_normal = normalised_or(b0 * object.normals[v.x] + b1 * object.normals[v.y] + b2 * object.normals[v.z], s.normal);
    if (glm::dot(s.normal, s.shading_normal) < 0) s.normal = -s.normal;
  }
  if (!shape.uses_uvs) return;
  const vec2 &t0 = object.uvs[v.x], &t1 = object.uvs[v.y], &t2 = object.uvs[v.z];
  s.uv = b0 * t0 + b1 * t1 + b2 * t2;
  s.tangent = triangle_tangent(triangle.e1, triangle.e2, t1 - t0, t2 - t0, s.normal);
}

void set_triangle_surface(const Object& object, const Shape& shape, const Hit& hit, SurfacePoint& s) {
  const Geometry& g = object.geometry;
  const uvec3 v = g.triangles[hit.primitive];
  const TrianglePlane triangle(g.positions[v.x], g.positions[v.y], g.positions[v.z]);
  const TrianglePoint point = point_of(triangle, hit.uv);
  const vec3 normal = shape.flip_normal ? -triangle.normal : triangle.normal;
  s.position = point.position;
  s.clearance = point.clearance;
  s.normal = s.shading_normal = normal;
  s.uv = {hit.uv.x + hit.uv.y, hit.uv.y};  // (0, 0), (1, 0), (1, 1)
  s.tangent = triangle.e1;
  if (shape.has_normals || shape.uses_uvs) set_vertex_values(object, shape, hit, triangle, s);
}

// Points are moved onto the surface exactly, so that rays leaving them start where they should.
struct QuadricSurface {
  const vec3& p;
  const vec2& uv;

  QuadricPoint operator()(const Sphere& s) const {
    const vec3 n = normalised_or(p - s.centre, {0, 0, 1});
    return {s.centre + s.radius * n, n, n, {-n.y, n.x, 0}, uv};
  }
  QuadricPoint operator()(const Disk& d) const {
    const vec3 position = p - glm::dot(p - d.centre, d.normal) * d.normal;
    return {position, d.normal, d.normal, Frame::from_normal(d.normal).tangent, uv};
  }
  QuadricPoint operator()(const Cylinder& c) const {
    // The tube and its caps keep off each other, as points of triangles keep off their edges.
    const float extent = c.length + 4 * c.radius + max_component(glm::abs(p));
    const float margin = c.caps ? std::min(16 * unit_roundoff * extent, 0.25f * std::min(c.length, c.radius)) : 0;
    const vec3 from_base = p - c.base;
    const float along = glm::dot(from_base, c.axis);
    if (c.caps && (uv.y == 0 || uv.y == 1)) {
      const vec3 across = from_base - along * c.axis, normal = uv.y == 0 ? -c.axis : c.axis;
      const float inwards = std::min(1.0f, (c.radius - margin) / glm::length(across));
      return {c.base + (uv.y * c.length * c.axis + inwards * across), normal, normal, Frame::from_normal(normal).tangent, uv};
    }
    const vec3 on_axis = c.base + std::clamp(along, margin, c.length - margin) * c.axis;
    const vec3 n = normalised_or(p - on_axis, Frame::from_normal(c.axis).tangent);
    return {on_axis + c.radius * n, n, n, glm::cross(c.axis, n), uv};
  }
};

// By which a ray that met a surface at `t` steps back.
vec3 retreat_of(const Ray& ray, float t, float clearance) {
  return std::min(most_clearances * clearance, most_of_way * t) * -ray.direction;
}

// At a point `p` of the object's space that rounding took off the quadric.
[[gnu::noinline]] void set_quadric_surface(const Object& object, const Shape& shape, const Hit& hit, const vec3& p,
                                           SurfacePoint& s) {
  const Quadric& quadric = object.geometry.quadric(hit.primitive);
  const QuadricPoint on = std::visit(QuadricSurface{p, hit.uv}, quadric);
  s.position = on.position;
  s.normal = shape.flip_normal ? -on.normal : on.normal;
  s.shading_normal = shape.flip_normal ? -on.shading_normal : on.shading_normal;
  s.tangent = on.tangent;
  s.uv = on.uv;
  s.clearance = clearance_of(s.position, quadric_extent(quadric));
}

[[gnu::noinline]] void place_in_world(const Transform& to_world, SurfacePoint& s) {
  const vec3 local = s.position;
  s.position = to_world.point(local);
  s.normal = glm::normalize(to_world.normal(s.normal));
  s.shading_normal = glm::normalize(to_world.normal(s.shading_normal));
  s.tangent = to_world.vector(s.tangent);
  s.clearance = rounding_at(s.position) + glm::length(to_world.error(s.position, local, s.clearance));
}

[[gnu::noinline]] void set_plane_surface(const InfinitePlane& plane, const vec3& p, SurfacePoint& s) {
  s.position = p - glm::dot(p - plane.point, plane.normal) * plane.normal;
  s.normal = s.shading_normal = plane.normal;
  const Frame frame = Frame::from_normal(plane.normal);
  s.tangent = frame.tangent;
  const vec3 off = s.position - plane.point;
  s.uv = {glm::dot(off, frame.tangent), glm::dot(off, frame.bitangent)};
  s.material = plane.material;
  s.light = no_id;
  s.clearance = clearance_of(s.position, max_component(glm::abs(off)));
}

std::uint32_t light_of(const Shape& shape, const Hit& hit) {
  return shape.first_light == no_id || hit.instance != 0 ? no_id : shape.first_light + (hit.primitive - shape.first_primitive);
}

}  // namespace

Bounds Scene::bounds() const {
  std::vector<Bounds> of_object(objects.size());
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const Geometry& g = objects[o].geometry;
    for (std::uint32_t i = 0; i < g.primitive_count(); ++i)
      if (g.is_valid(i)) of_object[o].extend(g.primitive_bounds(i));
  }
  Bounds all;
  for (const Instance& instance : instances) all.extend(instance.to_world.bounds(of_object[instance.object]));
  return all;
}

std::uint64_t Scene::triangle_count() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances) count += objects[instance.object].geometry.triangles.size();
  return count;
}

void Scene::prefetch_surface(const Hit& hit) const {
  if (hit.instance == plane_instance) return;
  const Object& object = objects[instances[hit.instance].object];
  if (!object.geometry.is_triangle(hit.primitive)) return;
  if (!object.shape_of.empty()) __builtin_prefetch(&object.shape_of[hit.primitive]);
  const uvec3 v = object.geometry.triangles[hit.primitive];
  for (const std::uint32_t i : {v.x, v.y, v.z}) {
    __builtin_prefetch(&object.geometry.positions[i]);
    if (!object.normals.empty()) __builtin_prefetch(&object.normals[i]);
    if (!object.uvs.empty()) __builtin_prefetch(&object.uvs[i]);
  }
}

SurfacePoint Scene::surface_at(const Ray& ray, const Hit& hit) const {
  SurfacePoint s;  // returned by every path, so that it is made where the caller wants it and not copied
  if (hit.instance == plane_instance) {
    set_plane_surface(planes[hit.primitive], ray.at(hit.t), s);
    s.retreat = retreat_of(ray, hit.t, s.clearance);
    return s;
  }
  const Instance& instance = instances[hit.instance];
  const Object& object = objects[instance.object];
  const Shape& shape = object.shape(hit.primitive);
  s.material = shape.material;
  s.light = light_of(shape, hit);
  if (object.geometry.is_triangle(hit.primitive))
    set_triangle_surface(object, shape, hit, s);
  else
    set_quadric_surface(object, shape, hit, hit.instance == 0 ? ray.at(hit.t) : instance.to_world.inverse_point(ray.at(hit.t)),
                        s);
  if (hit.instance != 0) place_in_world(instance.to_world, s);
  s.retreat = retreat_of(ray, hit.t, s.clearance);
  return s;
}

void finish_scene(Scene& scene, const std::vector<Emission>& emissions) {
  CHECK(!scene.instances.empty() && scene.instances[0].object == 0 && scene.instances[0].to_world.is_identity());
  for (const Instance& instance : scene.instances) CHECK_LT(instance.object, scene.objects.size());
  for (Object& object : scene.objects) {
    const Geometry& g = object.geometry;
    std::uint32_t next = 0;
    for (Shape& shape : object.shapes) {
      CHECK_EQ(shape.first_primitive, next);
      next += shape.primitive_count;
      CHECK_LT(shape.material, scene.materials.size());
      CHECK(!shape.has_normals || object.normals.size() == g.positions.size());
      CHECK(!shape.has_uvs || object.uvs.size() == g.positions.size());
      shape.uses_uvs = shape.has_uvs && uses_uvs(scene.materials[shape.material]);
    }
    CHECK_EQ(next, g.primitive_count());
    for (const uvec3& t : g.triangles) CHECK(t.x < g.positions.size() && t.y < g.positions.size() && t.z < g.positions.size());
    if (object.shapes.size() < 2) continue;
    object.shape_of.resize(g.primitive_count());
    for (std::uint32_t s = 0; s < object.shapes.size(); ++s)
      std::fill_n(object.shape_of.begin() + object.shapes[s].first_primitive, object.shapes[s].primitive_count, s);
  }
  for (const Emission& emission : emissions) {
    CHECK_LT(emission.shape, scene.objects[0].shapes.size());
    Shape& shape = scene.objects[0].shapes[emission.shape];
    shape.first_light = static_cast<std::uint32_t>(scene.lights.size());
    for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
      scene.lights.emplace_back(AreaLight{shape.first_primitive + i, emission.radiance, emission.two_sided});
  }
  recentre(scene);
}

}  // namespace etendue
