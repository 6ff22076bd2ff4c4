// A scene: geometry per object, instances of objects, what surfaces are made of, lights, a camera, and, where there is one, the
// exact answer.
#pragma once

#include "framework/materials/material.h"
#include "framework/materials/relief.h"
#include "framework/query.h"
#include "framework/scene/camera.h"
#include "framework/scene/geometry.h"
#include "framework/scene/layer.h"
#include "framework/scene/light.h"
#include "framework/scene/pixel_filter.h"
#include "framework/scene/transform.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace etendue {

// A run of primitives that share material and vertex attributes.
struct Shape {
  std::uint32_t first_primitive = 0, primitive_count = 0;
  std::uint32_t material = 0;
  std::uint32_t first_light = no_id;  // light of the first primitive; the others follow. no_id: does not emit
  bool flip_normal = false;           // the geometric normal is minus the winding's (or the quadric's outward one)
  bool has_normals = false, has_uvs = false;
  bool uses_uvs = false;         // has them, and its material, relief or emission depends on them; set by finish_scene
  std::uint32_t relief = no_id;  // index into Scene::reliefs; set by finish_scene
  // Index into Scene::textures: the share of rays that the surface stops; no_id: all of them. Of one that emits they see all of
  // its radiance, stopped or not.
  std::uint32_t mask = no_id;
};

struct Object {
  Geometry geometry;
  std::vector<vec3> normals;            // per vertex, or empty when no shape has them
  std::vector<vec2> uvs;                // likewise
  std::vector<Shape> shapes;            // in order of first_primitive, covering all primitives
  std::vector<std::uint32_t> shape_of;  // per primitive; empty when there is one shape

  const Shape& shape(std::uint32_t primitive) const { return shapes[shape_of.empty() ? 0 : shape_of[primitive]]; }
};

struct Instance {
  std::uint32_t object = 0;
  Transform to_world;
};

// A plane is infinite, so it is outside every ray structure and tested on its own. The normal (unit) tells the outer side.
struct InfinitePlane {
  vec3 point{0};
  vec3 normal{0, 0, 1};
  std::uint32_t material = 0;
};

// The point where a ray met a surface, in world space. `normal` is geometric and outward as the shape defines it (not towards
// the ray); `shading_normal` is on the same side.
//
// No rounding error takes a ray through a wall if it starts where ray_origin (framework/transport/ray_tools.h) says:
// `clearance` off the surface, and back by `retreat` on the way that the point was found by. All of that way is known to be
// free, so that a wall that meets this one nearer than floats can tell stays in front of the ray.
struct SurfacePoint {
  vec3 position;
  vec3 normal;
  vec3 shading_normal;
  vec3 tangent;  // dp/du, not normalised; of the triangle itself where the material does not use_uvs, and so is uv
  vec2 uv;
  std::uint32_t material;
  std::uint32_t light;  // index into Scene::lights, or no_id
  float clearance = 0;  // metres along the normal, to either side
  vec3 retreat{0};      // metres
  Layer layer = 0;
};

struct NamedCamera {
  std::string name;
  Camera camera;
  ivec2 resolution;
  std::optional<std::array<float, 4>> crop = {};   // as Scene::crop
  std::shared_ptr<const PixelFilter> filter = {};  // as Scene::filter
};

// The exact radiance along a camera ray, unlimited in depth; the harness averages it over each pixel.
struct ClosedForm {
  std::string source;  // which fact, for the report
  std::function<dvec3(const Ray& ray)> radiance;
};

struct Scene {
  std::string name;
  vec3 origin{0};                               // where 0 lies in the file's coordinates, metres: see recentre.h
  std::vector<Object> objects{1};               // 0: the world's own geometry
  std::vector<Instance> instances{Instance{}};  // 0: object 0, identity
  std::vector<InfinitePlane> planes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Relief> reliefs;  // at most one of a material; of triangles with texture coordinates
  std::vector<Light> lights;
  Camera camera;
  ivec2 resolution{256, 256};
  std::vector<NamedCamera> cameras;           // all that the file has, where there are several: `camera` is one of them
  std::optional<std::array<float, 4>> crop;   // x0, x1, y0, y1: the part that the file shows, in shares of the image
  std::shared_ptr<const PixelFilter> filter;  // of the image; null: a box one pixel wide
  std::optional<int> max_depth;               // scattering events, where the file states it
  std::optional<ClosedForm> closed_form;
  std::vector<std::string> warnings;  // of the reader: what was skipped, and why

  bool has_instances() const { return instances.size() > 1; }
  bool has_masks() const;                // a shape lets some rays through
  bool has_passed_lights() const;        // one that emits does
  Bounds bounds() const;                 // of everything but planes
  std::uint64_t triangle_count() const;  // of every instance
  std::uint64_t hash() const;            // of all that changes an image (XXH3)
  std::uint64_t content_hash() const;    // the same without camera, resolution and max_depth
  SurfacePoint surface_at(const Ray& ray, const Hit& hit) const;
  // The shading normal with the relief of the triangle's shape, which has one.
  vec3 normal_of_relief(const Hit& hit, const vec3& normal, const vec3& shading_normal, const vec2& uv) const;
  // The share of rays, from 0 to 1, that the surface stops where this one met it. What a structure of the scene answers has
  // already been stopped (accel/scene/with_masks.h).
  float opacity_at(const Hit& hit) const;
  bool emits_at(const Hit& hit) const;  // from one side at least
  Layer layer_at(const Hit& hit) const;
  // Serves loops that call surface_at for one hit after another. At hit number `begun` it begins to load what the calls for
  // hits a few places further on will read. It is worth its time where the scene outgrows the nearest caches.
  void prefetch_surfaces(std::span<const Hit> hits, std::size_t begun) const;
  bool outgrows_caches() const { return objects.size() > 1 || objects[0].geometry.triangles.size() > 2000; }
};

// Fills shape_of where needed, checks indices (CHECK: a reader's mistake), and appends an AreaLight per primitive of emitting
// shapes, and moves a distant scene to the origin. Readers call it last.
struct Emission {
  std::uint32_t shape;  // of object 0
  Rgb radiance;
  bool two_sided;
  std::uint32_t texture = no_id;  // by which the radiance is multiplied; the shape then is a mesh with texture coordinates
};
void finish_scene(Scene& scene, const std::vector<Emission>& emissions);

}  // namespace etendue
