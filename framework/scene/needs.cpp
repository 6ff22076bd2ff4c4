#include "framework/scene/needs.h"

#include "framework/core/elementary.h"

namespace etendue {

namespace {

// Can a light send anything straight into a box? Conservative: occluders are not looked at, "yes" may be wrong, "no" never is.
class Reaches {
 public:
  Reaches(const Scene& scene, const Bounds& box) : scene_(scene), box_(box) {}

  bool operator()(const AreaLight& l) const {
    const Object& world = scene_.objects[0];
    const Shape& shape = world.shape(l.primitive);
    if (l.two_sided || !world.geometry.is_triangle(l.primitive) || shape.has_normals) return true;
    const uvec3 v = world.geometry.triangles[l.primitive];
    const auto& p = world.geometry.positions;
    const vec3 normal = glm::cross(p[v.y] - p[v.x], p[v.z] - p[v.x]) * (shape.flip_normal ? -1.0f : 1.0f);
    return any_corner([&](const vec3& corner) { return glm::dot(corner - p[v.x], normal) > 0; });
  }
  bool operator()(const SpotLight& l) const {
    if (box_.contains(l.position)) return true;
    // The box's bounding sphere against the cone.
    const vec3 to_centre = box_.centre() - l.position;
    const float distance = glm::length(to_centre), radius = 0.5f * glm::length(box_.diagonal());
    if (distance <= radius) return true;
    const float angle = math::acos(std::clamp(glm::dot(to_centre, l.direction) / distance, -1.0f, 1.0f));
    return angle <= math::acos(l.cos_outer) + math::asin(radius / distance);
  }
  bool operator()(const PointLight&) const { return true; }
  bool operator()(const DirectionalLight&) const { return true; }
  bool operator()(const EnvironmentLight&) const { return true; }

 private:
  template <class Predicate>
  bool any_corner(const Predicate& predicate) const {
    for (int i = 0; i < 8; ++i)
      if (predicate(vec3(i & 1 ? box_.upper.x : box_.lower.x, i & 2 ? box_.upper.y : box_.lower.y,
                         i & 4 ? box_.upper.z : box_.lower.z)))
        return true;
    return false;
  }

  const Scene& scene_;
  const Bounds& box_;
};

bool light_reaches(const Scene& scene, const Bounds& box) {
  return std::any_of(scene.lights.begin(), scene.lights.end(),
                     [&](const Light& light) { return std::visit(Reaches(scene, box), light); });
}

bool specular_in_light(const Scene& scene) {
  for (const InfinitePlane& plane : scene.planes)
    if (has_specular(scene.materials[plane.material]) && !scene.lights.empty()) return true;
  for (const Instance& instance : scene.instances) {
    const Object& object = scene.objects[instance.object];
    for (const Shape& shape : object.shapes) {
      if (!has_specular(scene.materials[shape.material])) continue;
      Bounds bounds;
      for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
        bounds.extend(object.geometry.primitive_bounds(shape.first_primitive + i));
      if (!bounds.empty() && light_reaches(scene, instance.to_world.bounds(bounds))) return true;
    }
  }
  return false;
}

bool has_glossy_lobe(const Material& material) {
  if (const auto* p = std::get_if<Plastic>(&material)) return p->alpha != 0;
  const bool is_even = std::holds_alternative<Diffuse>(material) || std::holds_alternative<DiffuseTransmission>(material);
  return !is_even && has_non_specular(material);
}

}  // namespace

SceneNeeds scene_needs(const Scene& scene) {
  SceneNeeds n;
  n.caustic_map = specular_in_light(scene);
  n.two_levels = scene.has_instances();
  n.planes = !scene.planes.empty();
  n.light_choice = scene.lights.size() > 1;
  n.textures = !scene.textures.empty();
  n.masks = scene.has_masks();
  n.passed_lights = scene.has_passed_lights();
  n.thin_lens = scene.camera.lens_radius > 0;
  for (const Object& object : scene.objects) {
    n.quadrics |= !object.geometry.quadrics.empty();
    for (const Shape& shape : object.shapes) n.shading_normals |= shape.has_normals || shape.relief != no_id;
  }
  for (const Light& light : scene.lights) n.environment |= std::holds_alternative<EnvironmentLight>(light);
  for (const Material& material : scene.materials) n.glossy |= has_glossy_lobe(material);
  return n;
}

std::vector<SceneNeeds::Line> SceneNeeds::lines(const Scene& scene) const {
  const auto count = [](std::size_t n, const char* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); };
  std::size_t quadric_count = 0;
  for (const Object& object : scene.objects) quadric_count += object.geometry.quadrics.size();
  return {
      {"caustic photon map", caustic_map,
       caustic_map ? "a specular surface that light can reach" : "no specular surface that light can reach"},
      {"two-level structure", two_levels, count(scene.instances.size() - 1, "instance")},
      {"quadric leaf", quadrics, count(quadric_count, "quadric")},
      {"plane test", planes, count(scene.planes.size(), "infinite plane")},
      {"choice of lights", light_choice, count(scene.lights.size(), "light")},
      {"texture lookup", textures, count(scene.textures.size(), "texture")},
      {"opacity test", masks, masks ? "a surface that lets rays through" : "all surfaces are opaque"},
      {"shading normals", shading_normals,
       shading_normals ? "meshes with vertex normals or relief" : "no mesh has vertex normals or relief"},
      {"environment lookup", environment, environment ? "a light at infinity" : "no light at infinity"},
      {"lens sampling", thin_lens, thin_lens ? "the lens has an aperture" : "the camera is a pinhole"},
      {"glossy lobes", glossy, glossy ? "a rough conductor, dielectric or coat" : "all surfaces are diffuse or specular"},
  };
}

}  // namespace etendue
