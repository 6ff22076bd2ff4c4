// A grid that tells where walls may stand between a point and what it gathers: photons, light vertices, values computed
// beforehand.
//
// A gather of radius r counts what lies within r, and behind a thin wall, round a sharp fold or beyond a corner there is light
// that never reaches the point. Two tests keep it out together. Both ends must face each other (the callers' side test), and
// nothing may stand on the way between them: from the point, off its surface, to a point on the last piece of the photon's own
// way, which is free since the photon flew there, as far before its landing as point and photon lie apart. A photon that landed
// outside of a closed wall came from outside, so that this way crosses the wall however sharp its folds are: no gather sees
// through it. Raised by the distance, the way also clears surfaces that curve away between the two, unless light grazes them.
//
// The second test takes a ray, which is traced only where the way crosses the plane of a surface near by. A grid over the
// scene's bounds lists for each cell the sheets of surface (planes and spheres) within the radius of it. Where there is one, it
// is the point's own; the side test decides on a plane and inside of a sphere. Where there are a few, a way whose ends lie on
// the same side of each, or that passes beside what lies on it, cannot be blocked. Where there are more, as on curved meshes
// that are coarse against the radius, every way is traced. Smooth glass without a tint is no wall, nor is a sphere to a way
// whose ends both lie outside: across one that is smaller than the kernel light is blurred.
//
// What the test costs in accuracy: light that reaches the photon but, for want of a way, not the point is no longer blurred
// across the edge of a shadow within the radius; like all blur by the kernel it vanishes with the radius.
#pragma once

#include "framework/integrator.h"

#include <array>
#include <memory>
#include <vector>

namespace etendue {

// A plane, or a sphere, with its two sides, and a box about the surfaces that lie on it.
struct Sheet {
  vec3 normal_or_centre;
  float height_or_radius;
  bool is_sphere;
  Bounds bounds = {};

  bool operator==(const Sheet& other) const {
    return normal_or_centre == other.normal_or_centre && height_or_radius == other.height_or_radius &&
           is_sphere == other.is_sphere && bounds.lower == other.bounds.lower && bounds.upper == other.bounds.upper;
  }
  // Metres from it, negative below or inside.
  float height(const vec3& p) const {
    return (is_sphere ? glm::length(p - normal_or_centre) : glm::dot(p, normal_or_centre)) - height_or_radius;
  }
  // Farther from the surfaces than `distance` (metres)?
  bool is_beside(const vec3& p, float distance) const {
    return max_component(glm::max(bounds.lower - p, p - bounds.upper)) > distance;
  }
  vec3 normal_at(const vec3& p) const { return is_sphere ? glm::normalize(p - normal_or_centre) : normal_or_centre; }
};

inline constexpr std::size_t most_sheets = 32;

// The sheets about a point that gathers.
class NearWalls {
 public:
  bool none() const { return count_ == 0; }
  // May something within the radius hide the point `landed` of a surface, seen from its side where end() lies? A ray must tell.
  template <class End>
  bool may_hide(const vec3& landed, const End& end) const {
    if (count_ == too_many) return true;
    for (std::uint32_t i = 0; i < plane_count_; i += 4)
      if (any(~(planes_[i / 4].heights(landed) > rounding_))) {
        if (crosses_plane(end())) return true;
        break;
      }
    return sphere_count_ > 0 && crosses_sphere(landed, end());
  }

 private:
  friend class WallGrid;
  static constexpr int too_many = most_sheets + 1;

  // Four planes, turned so that the point is above them. Planes of zeros may hide all: of such are those of which floats cannot
  // tell the point's side.
  using Floats = float __attribute__((vector_size(16)));
  struct Planes {
    Floats x, y, z, height;

    Floats heights(const vec3& p) const { return x * p.x + y * p.y + z * p.z - height; }
  };
  void add(const Sheet& sheet, float side, bool own);
  bool crosses_plane(const vec3& end) const;
  bool crosses_sphere(const vec3& landed, const vec3& end) const;
  template <class Lanes>
  static bool any(Lanes lanes) {
    using Pair = std::int64_t __attribute__((vector_size(16)));
    return (Pair(lanes)[0] | Pair(lanes)[1]) != 0;
  }

  int count_ = 0;  // too_many: always
  std::uint32_t plane_count_ = 0, sphere_count_ = 0;
  float rounding_ = 0;
  vec3 position_;
  std::array<Planes, most_sheets / 4> planes_;
  std::array<const Sheet*, most_sheets> of_planes_, spheres_;
  std::array<float, most_sheets> side_;  // of the point, at each sphere: 1 outside, -1 inside, or 0
};

class WallGrid {
 public:
  // The grid serves gathers of at most `radius` (metres).
  WallGrid(const Scene& scene, float radius);

  float radius() const { return radius_; }
  // About a surface point that gathers on the side of unit `normal`, within `radius`. `side_test`: what landed on another side
  // is refused beforehand, and not by the BSDF alone.
  NearWalls near(const vec3& position, const vec3& normal, float radius, bool side_test = true) const;

 private:
  struct Cell {
    std::uint32_t first = 0;  // of its sheets
    std::uint32_t count = 0;  // NearWalls::too_many: they are not listed
  };
  struct Range {
    uvec3 begin, end;
  };
  class Slab;

  Range cells_about(const Bounds& bounds) const;
  vec3 centre(const uvec3& cell) const { return lower_ + (vec3(cell) + 0.5f) * cell_size_; }
  std::size_t index(const uvec3& c) const { return (static_cast<std::size_t>(c.z) * size_.y + c.y) * size_.x + c.x; }

  float radius_, rounding_ = 0;
  std::size_t longest_list_;  // of a cell's sheets
  vec3 lower_{0};
  float cell_size_ = 1, cells_per_metre_ = 1;
  uvec3 size_{0};
  std::vector<Cell> cells_;
  std::vector<Sheet> sheets_;
};

// The grid for gathers of `radius`: `grid` itself if it serves that radius and was not made for more than twice that.
std::shared_ptr<const WallGrid> wall_grid(const Scene& scene, float radius, std::shared_ptr<const WallGrid> grid);

// The end of the way that must be free from a point `distance` away, if light came from unit `direction` over `flown` metres to
// land at `landed`.
inline vec3 before_landing(const vec3& landed, const vec3& direction, float flown, float distance) {
  return landed + std::min(distance, 0.5f * flown) * direction;
}

}  // namespace etendue
