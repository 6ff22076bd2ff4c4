// Mitsuba's cameras see nothing nearer than near_clip and nothing beyond far_clip, which are depths along the view.
// Cameras here see all of it, and a warning says where that makes a difference, unless something hides it.

#include "framework/io/mitsuba/reader.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace etendue {

namespace {

// Between two depths of a view, in camera space (of a lens, a little more of it): `planes` are those around it, each with its
// inner side where dot(vec3(plane), p) + plane.w is positive.
class ViewSlab {
 public:
  ViewSlab(const Camera& camera, ivec2 resolution, float from, float to) : from_(from), to_(to) {
    const vec2 extent = camera.half_extent(resolution);
    const vec2 slope = camera.is_parallel() ? vec2(0) : extent,
               width = camera.is_parallel() ? extent : vec2(camera.lens_radius);
    planes_ = {vec4(0, 0, 1, -from),          vec4(0, 0, -1, to),           vec4(1, 0, slope.x, width.x),
               vec4(-1, 0, slope.x, width.x), vec4(0, 1, slope.y, width.y), vec4(0, -1, slope.y, width.y)};
  }

  // Does any of a convex polygon of at most four corners lie in it?
  bool meets(std::span<const vec3> corners) const {
    const auto beyond = [&](const vec3& p) { return p.z < from_ ? -1 : p.z > to_ ? 1 : 0; };
    const int side = beyond(corners[0]);
    if (side != 0 && std::ranges::all_of(corners, [&](const vec3& p) { return beyond(p) == side; })) return false;
    // A plane adds a corner, or, where rounding makes signs alternate, one for each two: of 4 there are 42 at most after six.
    std::array<vec3, 42> polygon, kept;
    std::size_t count = corners.size();
    std::ranges::copy(corners, polygon.begin());
    for (const vec4& plane : planes_) {
      std::size_t left = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const vec3 &a = polygon[i], &b = polygon[(i + 1) % count];
        const float of_a = glm::dot(vec3(plane), a) + plane.w, of_b = glm::dot(vec3(plane), b) + plane.w;
        if (of_a >= 0) kept[left++] = a;
        if ((of_a >= 0) != (of_b >= 0)) kept[left++] = glm::mix(a, b, of_a / (of_a - of_b));
      }
      if (left == 0) return false;
      std::swap(polygon, kept);
      count = left;
    }
    return true;
  }

 private:
  float from_, to_;
  std::array<vec4, 6> planes_;
};

// Quadrics count by the faces of their boxes.
bool holds_surfaces(const ViewSlab& slab, const Scene& scene, const Transform& to_camera) {
  for (const Instance& instance : scene.instances) {
    const Transform t = to_camera * instance.to_world;
    const Geometry& geometry = scene.objects[instance.object].geometry;
    for (const uvec3& triangle : geometry.triangles) {
      std::array<vec3, 3> corners;
      for (int i = 0; i < 3; ++i) corners[i] = t.point(geometry.positions[triangle[i]]);
      if (slab.meets(corners)) return true;
    }
    for (const Quadric& quadric : geometry.quadrics) {
      const Bounds box = quadric_bounds(quadric);
      for (int face = 0; face < 6; ++face) {
        std::array<vec3, 4> corners;
        for (int i = 0; i < 4; ++i) {
          vec3 corner;
          corner[face / 2] = face % 2 == 0 ? box.lower[face / 2] : box.upper[face / 2];
          corner[(face / 2 + 1) % 3] = i == 1 || i == 2 ? box.upper[(face / 2 + 1) % 3] : box.lower[(face / 2 + 1) % 3];
          corner[(face / 2 + 2) % 3] = i >= 2 ? box.upper[(face / 2 + 2) % 3] : box.lower[(face / 2 + 2) % 3];
          corners[i] = t.point(corner);
        }
        if (slab.meets(corners)) return true;
      }
    }
  }
  return false;
}

}  // namespace

void MitsubaReader::keep_clipping(const Properties& of) {
  const float near = of.number("near_clip", 1e-2f, 0), far = of.number("far_clip", 1e4f, near);
  clippings_.push_back({of.title(), of.where("near_clip"), of.where("far_clip"), scene_.camera, scene_.resolution, near, far});
}

void MitsubaReader::warn_of_clipping() {
  for (const Clipping& c : clippings_) {
    const Transform to_camera = c.camera.to_world.inverse();
    const auto holds = [&](float from, float to) {
      return holds_surfaces({c.camera, c.resolution, from, to}, scene_, to_camera);
    };
    if (holds(0, c.near))
      warn(c.where_near,
           fmt::format("{}: Mitsuba cuts away what is less than 'near_clip', {:g} m, deep in the view; here it is seen",
                       c.sensor, c.near));
    if (holds(c.far, infinity))
      warn(c.where_far,
           fmt::format("{}: Mitsuba cuts away what is more than 'far_clip', {:g} m, deep in the view; here it is seen",
                       c.sensor, c.far));
  }
}

}  // namespace etendue
