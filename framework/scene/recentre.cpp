#include "framework/scene/recentre.h"

namespace etendue {

namespace {

constexpr float far_extents = 16;

vec3 new_origin(const Bounds& bounds) {
  const float extent = max_component(bounds.diagonal());
  vec3 origin(0);
  if (bounds.empty()) return origin;
  for (int axis = 0; axis < 3; ++axis)
    if (const float centre = bounds.centre()[axis]; std::abs(centre) > far_extents * extent) origin[axis] = centre;
  return origin;
}

struct MovedQuadric {
  const vec3& by;

  void operator()(Cylinder& c) const { c.base += by; }
  void operator()(auto& round) const { round.centre += by; }
};

struct MovedLight {
  const vec3& by;

  void operator()(PointLight& l) const { l.position += by; }
  void operator()(SpotLight& l) const { l.position += by; }
  void operator()(const auto&) const {}
};

}  // namespace

void recentre(Scene& scene) {
  scene.origin = new_origin(scene.bounds());
  if (scene.origin == vec3(0)) return;
  const vec3 by = -scene.origin;
  Geometry& world = scene.objects[0].geometry;
  for (vec3& p : world.positions) p += by;
  for (Quadric& q : world.quadrics) std::visit(MovedQuadric{by}, q);
  for (std::size_t i = 1; i < scene.instances.size(); ++i) scene.instances[i].to_world = scene.instances[i].to_world.moved(by);
  for (InfinitePlane& plane : scene.planes) plane.point += by;
  for (Light& light : scene.lights) std::visit(MovedLight{by}, light);
  scene.camera.to_world = scene.camera.to_world.moved(by);
  for (NamedCamera& named : scene.cameras) named.camera.to_world = named.camera.to_world.moved(by);
  if (!scene.closed_form) return;
  scene.closed_form->radiance = [radiance = std::move(scene.closed_form->radiance), by](Ray ray) {
    ray.origin -= by;
    return radiance(ray);
  };
}

}  // namespace etendue
