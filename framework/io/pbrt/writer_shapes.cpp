// Shapes: meshes as files, quadrics by name, planes as disks.

#include "framework/core/elementary.h"
#include "framework/io/mesh/ply_write.h"
#include "framework/io/pbrt/writer.h"

namespace etendue {

using namespace pbrt_text;

namespace {

constexpr float plane_extents = 100;  // by which the disk in an infinite plane's place reaches beyond the scene

// The triangles of a shape with the vertices that they use, in order.
TriangleMesh mesh_of(const Object& object, const Shape& shape, bool flip_normal, const vec3& origin) {
  const Geometry& g = object.geometry;
  const auto first = g.triangles.begin() + shape.first_primitive, last = first + shape.primitive_count;
  std::uint32_t lowest = no_id, highest = 0;
  for (auto t = first; t != last; ++t)
    for (int i = 0; i < 3; ++i) {
      lowest = std::min(lowest, (*t)[i]);
      highest = std::max(highest, (*t)[i]);
    }
  std::vector<std::uint32_t> places(highest - lowest + 1, no_id);
  for (auto t = first; t != last; ++t)
    for (int i = 0; i < 3; ++i) places[(*t)[i] - lowest] = 0;
  TriangleMesh mesh;
  for (std::uint32_t v = lowest; v <= highest; ++v) {
    if (places[v - lowest] == no_id) continue;
    places[v - lowest] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(g.positions[v] + origin);
    // The reader turns normals, too. Adding 0 takes the sign from 0, as placing does.
    if (shape.has_normals) mesh.normals.push_back((flip_normal ? -object.normals[v] : object.normals[v]) + 0.0f);
    if (shape.has_uvs) mesh.uvs.push_back(object.uvs[v]);
  }
  for (auto t = first; t != last; ++t)
    mesh.triangles.emplace_back(places[t->x - lowest], places[t->y - lowest], places[t->z - lowest]);
  return mesh;
}

// A rotation that brings z to `axis`, which the reader normalises, and has no scale to the last bit. x lies along the tangent
// of [Duff2017] where directions around the axis count.
Transform turned_to(const vec3& axis, bool has_axes) {
  const vec3 z = direction_read_as(axis, [](const vec3& v) { return glm::normalize(v); });
  const Frame frame = Frame::from_normal(axis);
  vec3 x = frame.tangent, y = frame.bitangent;
  for (int step = 1; !has_axes && step < 64 && glm::length(x) != 1; ++step) {
    const float angle = 0.1f * static_cast<float>(step);
    x = math::cos(angle) * frame.tangent + math::sin(angle) * frame.bitangent;
    y = glm::cross(axis, x);
  }
  return Transform::from_matrix(mat4(vec4(x, 0), vec4(y, 0), vec4(z, 0), vec4(0, 0, 0, 1))).value_or(Transform());
}

std::string placement(const vec3& at, const vec3& signed_axis, bool has_axes) {
  const vec3 axis = signed_axis + 0.0f;  // the frame around an axis depends on the sign of 0
  std::string text = fmt::format("  Translate {} {} {}\n", number_text(at.x), number_text(at.y), number_text(at.z));
  if (axis == vec3(0, 0, 1)) return text;
  return text + "  Concat" + transform_text(turned_to(axis, has_axes));
}

std::string disk_text(float radius, float inner_radius) {
  return "Shape \"disk\" \"float radius\" " + bracketed({radius}) +
         (inner_radius > 0 ? " \"float innerradius\" " + bracketed({inner_radius}) : "");
}

}  // namespace

PbrtWriter::Look PbrtWriter::look_of(const Object& object, const Shape& shape) {
  const bool emits = &object == scene_.objects.data() && shape.first_light != no_id;
  const AreaLight* light = emits ? &std::get<AreaLight>(scene_.lights[shape.first_light]) : nullptr;
  if (light && is_black(light->radiance)) light = nullptr;
  if (light && shape.mask != no_id) warn("lights that let rays through: pbrt-v4 has none; written as lights that stop them");
  return {material_name(shape.material), shape.flip_normal, light, light ? no_id : shape.mask};
}

void PbrtWriter::add_shape(const std::string& placement, const std::string& shape, const Look& look) {
  shapes_ += "AttributeBegin\n" + placement + "  NamedMaterial " + in_quotes(look.material) + "\n";
  if (look.light)
    shapes_ += "  AreaLightSource \"diffuse\"" + rgb_text("L", look.light->radiance) +
               (look.light->two_sided ? " \"bool twosided\" [ true ]\n" : "\n");
  if (look.flip_normal) shapes_ += "  ReverseOrientation\n";
  shapes_ += "  " + shape + mask_text(look.mask) + "\nAttributeEnd\n";
}

void PbrtWriter::add_object(const Object& object, const vec3& origin) {
  for (const Shape& shape : object.shapes) {
    if (shape.primitive_count == 0) continue;
    const Look look = look_of(object, shape);
    if (object.geometry.is_triangle(shape.first_primitive)) {
      add_mesh(object, shape, look, origin);
      continue;
    }
    for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
      add_quadric(object.geometry.quadric(shape.first_primitive + i), look,
                  uses_uvs(scene_.materials[shape.material]) || shape.mask != no_id, origin);
  }
}

void PbrtWriter::add_mesh(const Object& object, const Shape& shape, const Look& look, const vec3& origin) {
  const std::string bytes = encode_ply(mesh_of(object, shape, look.flip_normal, origin));
  add_shape("", "Shape \"plymesh\" \"string filename\" " + file(numbered("mesh") + ".ply", bytes), look);
}

void PbrtWriter::add_quadric(const Quadric& quadric, const Look& look, bool has_axes, const vec3& origin) {
  struct Add {
    PbrtWriter& writer;
    const Look& look;
    bool has_axes;
    const vec3& origin;

    // A sphere's v runs up in pbrt, and down here. Lights have no texture.
    void operator()(const Sphere& s) const {
      writer.add_shape(placement(s.centre + origin, {0, 0, 1}, false) + (has_axes && !look.light ? "  Scale 1 1 -1\n" : ""),
                       "Shape \"sphere\" \"float radius\" " + bracketed({s.radius}), look);
    }
    void operator()(const Disk& d) const {
      writer.add_shape(placement(d.centre + origin, d.normal, has_axes), disk_text(d.radius, d.inner_radius), look);
    }
    void operator()(const Cylinder& c) const {
      writer.add_shape(placement(c.base + origin, c.axis, has_axes),
                       "Shape \"cylinder\" \"float radius\" " + bracketed({c.radius}) +
                           " \"float zmin\" [ 0 ] \"float zmax\" " + bracketed({c.length}),
                       look);
      if (!c.caps) return;
      writer.warn(
          "cylinders with caps: pbrt has none; taken as a tube and two disks, between which a ray may pass by rounding");
      for (const auto& [at, axis] : {std::pair(c.base, -c.axis), std::pair(c.base + c.length * c.axis, c.axis)})
        (*this)(Disk{at, c.radius, axis});
    }
  };
  std::visit(Add{*this, look, has_axes, origin}, quadric);
}

void PbrtWriter::add_plane(const InfinitePlane& plane) {
  Bounds bounds = scene_.bounds();
  bounds.extend(scene_.camera.to_world.point(vec3(0)));
  for (const Light& light : scene_.lights)
    if (const auto* point = std::get_if<PointLight>(&light)) bounds.extend(point->position);
  bounds.extend(plane.point);
  const float radius = plane_extents * std::max(max_component(bounds.diagonal()), 1e-3f);
  const vec3 middle = bounds.centre(), centre = middle - glm::dot(middle - plane.point, plane.normal) * plane.normal;
  warn(fmt::format("infinite planes: pbrt has none; taken as disks of {:.3g} m, beyond which nothing is seen", radius));
  add_quadric(Disk{centre, radius, plane.normal}, {material_name(plane.material)}, false, scene_.origin);
}

}  // namespace etendue
