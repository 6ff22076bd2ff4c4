#include "framework/scene/scene.h"

#include "framework/core/check.h"
#include "framework/scene/recentre.h"
#include "framework/scene/triangle_surface.h"

#include <algorithm>
#include <tuple>

namespace etendue {

namespace {

struct QuadricPoint {
  vec3 position, normal, shading_normal, tangent;
  vec2 uv;
};

void set_triangle_surface(const Object& object, const Shape& shape, const Ray& ray, const Hit& hit, SurfacePoint& s) {
  const Geometry& g = object.geometry;
  const uvec3 v = g.triangles[hit.primitive];
  const TriangleHit<float> met{g.positions[v.x], g.positions[v.y], g.positions[v.z], hit.uv, hit.t,
                               ray.direction,    shape.flip_normal};
  SurfaceOf<float> on;
  if (shape.has_normals || shape.uses_uvs) [[unlikely]] {
    CornerValues<float> corners{shape.has_normals, shape.uses_uvs, {}, {}, {}, {}, {}, {}};
    if (shape.has_normals)
      std::tie(corners.n0, corners.n1, corners.n2) = std::tie(object.normals[v.x], object.normals[v.y], object.normals[v.z]);
    if (shape.uses_uvs)
      std::tie(corners.uv0, corners.uv1, corners.uv2) = std::tie(object.uvs[v.x], object.uvs[v.y], object.uvs[v.z]);
    on = triangle_surface<float>(met, &corners);
  } else {
    on = triangle_surface<float>(met);
  }
  s.position = on.position;
  s.normal = on.normal;
  s.shading_normal = on.shading_normal;
  s.tangent = on.tangent;
  s.uv = on.uv;
  s.clearance = on.clearance;
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
    return {position, d.normal, d.normal, glm::cross(d.normal, position - d.centre), uv};
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
      return {c.base + (uv.y * c.length * c.axis + inwards * across), normal, normal, glm::cross(c.axis, across), uv};
    }
    const vec3 on_axis = c.base + std::clamp(along, margin, c.length - margin) * c.axis;
    const vec3 n = normalised_or(p - on_axis, Frame::from_normal(c.axis).tangent);
    return {on_axis + c.radius * n, n, n, glm::cross(c.axis, n), uv};
  }
};

// Sets the surface at `p`, a point of the object's space that rounding took off the quadric.
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

bool Scene::has_masks() const {
  return std::ranges::any_of(objects, [](const Object& object) {
    return std::ranges::any_of(object.shapes, [](const Shape& shape) { return shape.mask != no_id; });
  });
}

bool Scene::has_passed_lights() const {
  return std::ranges::any_of(objects[0].shapes,
                             [](const Shape& shape) { return shape.mask != no_id && shape.first_light != no_id; });
}

bool Scene::emits_at(const Hit& hit) const {
  return hit.instance != plane_instance && light_of(objects[instances[hit.instance].object].shape(hit.primitive), hit) != no_id;
}

float Scene::opacity_at(const Hit& hit) const {
  if (hit.instance == plane_instance) return 1;
  const Object& object = objects[instances[hit.instance].object];
  const Shape& shape = object.shape(hit.primitive);
  if (shape.mask == no_id) return 1;
  vec2 uv = hit.uv;
  if (shape.has_uvs) {
    const uvec3 v = object.geometry.triangles[hit.primitive];
    uv = (1 - hit.uv.x - hit.uv.y) * object.uvs[v.x] + hit.uv.x * object.uvs[v.y] + hit.uv.y * object.uvs[v.z];
  }
  return std::clamp(mean_component(evaluate(textures[shape.mask], uv)), 0.0f, 1.0f);
}

Layer Scene::layer_at(const Hit& hit) const {
  if (hit.instance == plane_instance) return 0;
  const Object& object = objects[instances[hit.instance].object];
  const Shape& shape = object.shape(hit.primitive);
  if (shape.mask == no_id) return 0;
  const std::size_t number = static_cast<std::size_t>(&shape - object.shapes.data()) + hit.instance;
  return static_cast<Layer>((1 + number % layer_shapes) | (opacity_at(hit) < opaque_from ? layer_lets_light_through : 0));
}

std::uint64_t Scene::triangle_count() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances) count += objects[instance.object].geometry.triangles.size();
  return count;
}

void Scene::prefetch_surfaces(std::span<const Hit> hits, std::size_t begun) const {
  constexpr std::size_t corners_ahead = 4, indices_ahead = 12;  // as long as memory takes, twice
  const auto object_of = [&](std::size_t i) -> const Object* {
    if (i >= hits.size() || !hits[i] || hits[i].instance == plane_instance) return nullptr;
    const Object& object = objects[instances[hits[i].instance].object];
    return object.geometry.is_triangle(hits[i].primitive) ? &object : nullptr;
  };
  if (const Object* object = object_of(begun + indices_ahead)) {
    const std::uint32_t primitive = hits[begun + indices_ahead].primitive;
    __builtin_prefetch(&object->geometry.triangles[primitive]);
    if (!object->shape_of.empty()) __builtin_prefetch(&object->shape_of[primitive]);
  }
  const Object* object = object_of(begun + corners_ahead);
  if (object == nullptr) return;
  const std::uint32_t primitive = hits[begun + corners_ahead].primitive;
  const Shape& shape = object->shape(primitive);
  const uvec3 v = object->geometry.triangles[primitive];
  for (const std::uint32_t i : {v.x, v.y, v.z}) {
    __builtin_prefetch(&object->geometry.positions[i]);
    if (shape.has_normals) __builtin_prefetch(&object->normals[i]);
    if (shape.uses_uvs) __builtin_prefetch(&object->uvs[i]);
  }
}

SurfacePoint Scene::surface_at(const Ray& ray, const Hit& hit) const {
  SurfacePoint s;  // returned by every path, so that it is made where the caller wants it and not copied
  if (hit.instance == plane_instance) {
    set_plane_surface(planes[hit.primitive], ray.at(hit.t), s);
    s.retreat = retreat_of(ray.direction, hit.t, s.clearance);
    return s;
  }
  const Instance& instance = instances[hit.instance];
  const Object& object = objects[instance.object];
  const Shape& shape = object.shape(hit.primitive);
  s.material = shape.material;
  s.light = light_of(shape, hit);
  if (object.geometry.is_triangle(hit.primitive))
    set_triangle_surface(object, shape, ray, hit, s);
  else
    set_quadric_surface(object, shape, hit, hit.instance == 0 ? ray.at(hit.t) : instance.to_world.inverse_point(ray.at(hit.t)),
                        s);
  if (hit.instance != 0) place_in_world(instance.to_world, s);
  if (shape.relief != no_id) [[unlikely]]
    s.shading_normal = normal_of_relief(hit, s.normal, s.shading_normal, s.uv);
  if (shape.mask != no_id) [[unlikely]]
    s.layer = layer_at(hit);
  s.retreat = retreat_of(ray.direction, hit.t, s.clearance);
  return s;
}

[[gnu::noinline]] vec3 Scene::normal_of_relief(const Hit& hit, const vec3& normal, const vec3& shading_normal,
                                               const vec2& uv) const {
  const Instance& instance = instances[hit.instance];
  const Object& object = objects[instance.object];
  const Relief& relief = reliefs[object.shape(hit.primitive).relief];
  const uvec3 v = object.geometry.triangles[hit.primitive];
  const auto& p = object.geometry.positions;
  const vec3 e1 = p[v.y] - p[v.x], e2 = p[v.z] - p[v.x];
  const vec2 d1 = object.uvs[v.y] - object.uvs[v.x], d2 = object.uvs[v.z] - object.uvs[v.x];
  const float determinant = d1.x * d2.y - d1.y * d2.x;
  if (std::abs(determinant) < 1e-12f) return shading_normal;
  vec3 dp_du = (d2.y * e1 - d1.y * e2) / determinant, dp_dv = (d1.x * e2 - d2.x * e1) / determinant;
  if (hit.instance != 0) {
    dp_du = instance.to_world.vector(dp_du);
    dp_dv = instance.to_world.vector(dp_dv);
  }
  return etendue::normal_of_relief(relief, textures[relief.texture], {normal, shading_normal, dp_du, dp_dv, uv});
}

void finish_scene(Scene& scene, const std::vector<Emission>& emissions) {
  CHECK(!scene.instances.empty() && scene.instances[0].object == 0 && scene.instances[0].to_world.is_identity());
  for (const Instance& instance : scene.instances) CHECK_LT(instance.object, scene.objects.size());
  std::vector<std::uint32_t> relief_of(scene.materials.size(), no_id);
  for (std::uint32_t r = 0; r < scene.reliefs.size(); ++r) {
    CHECK_LT(scene.reliefs[r].material, scene.materials.size());
    relief_of[scene.reliefs[r].material] = r;
  }
  for (Object& object : scene.objects) {
    const Geometry& g = object.geometry;
    std::uint32_t next = 0;
    for (Shape& shape : object.shapes) {
      CHECK_EQ(shape.first_primitive, next);
      next += shape.primitive_count;
      CHECK_LT(shape.material, scene.materials.size());
      CHECK(shape.mask == no_id || shape.mask < scene.textures.size());
      CHECK(!shape.has_normals || object.normals.size() == g.positions.size());
      CHECK(!shape.has_uvs || object.uvs.size() == g.positions.size());
      if (relief_of[shape.material] != no_id) shape.relief = relief_of[shape.material];
      CHECK(shape.relief == no_id || shape.has_uvs);
      shape.uses_uvs = shape.has_uvs && (shape.relief != no_id || uses_uvs(scene.materials[shape.material]));
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
    CHECK(emission.texture == no_id || shape.has_uvs);
    shape.uses_uvs |= emission.texture != no_id;
    shape.first_light = static_cast<std::uint32_t>(scene.lights.size());
    for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
      scene.lights.emplace_back(AreaLight{shape.first_primitive + i, emission.radiance, emission.two_sided, emission.texture});
  }
  recentre(scene);
}

}  // namespace etendue
