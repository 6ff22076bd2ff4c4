// The parts of space where photons matter: those near points at which they will be gathered.
//
// A grid over the scene's bounds, with a bit per octant of normals in each cell. `mark` sets those of every cell that a sphere
// touches, so that each photon within the sphere is found to matter (and a few just outside): the region is never too small.
// With a normal it sets the octants alone whose photons pass the side test there, so that the far side of a wall does not
// matter. What lies outside the bounds, on infinite planes, counts to the nearest cell. Marking is safe from many threads, and
// its result does not depend on their order.
#pragma once

#include "framework/integrator.h"
#include "integrators/photons/photons.h"

#include <atomic>
#include <memory>

namespace etendue {

class VisibleRegion {
 public:
  // Cells are half as wide as `reach`, the typical radius, but wide enough to be at most 2^24, and 1024 on each side.
  VisibleRegion(const Bounds& bounds, float reach);

  void mark(const vec3& position, float radius) { mark(position, radius, 0xff); }
  // Unit normal, on the side photons must have come from.
  void mark(const vec3& position, float radius, const vec3& normal) { mark(position, radius, octants_facing(normal)); }
  // Does a photon matter here, on the side with this normal?
  bool contains(const vec3& position, const vec3& normal) const;
  // Share of the cells that are marked.
  double share() const;

 private:
  using Octants = std::uint8_t;
  static Octants octants_facing(const vec3& normal);
  void mark(const vec3& position, float radius, Octants octants);
  uvec3 cell(const vec3& position) const;
  std::size_t index(const uvec3& c) const { return (static_cast<std::size_t>(c.z) * size_.y + c.y) * size_.x + c.x; }

  vec3 lower_{0};
  float cells_per_metre_ = 1;
  uvec3 size_{1};
  std::vector<std::atomic<Octants>> cells_;
};

// Camera paths to rough vertices, through specular-like ones: `samples` a pixel, of at most `max_depth` events.
struct SeenOptions {
  int samples = 4;
  int max_depth = 64;
  SamplerKind sampler = SamplerKind::sobol;
  bool side_test = true;  // else photons on every side matter
};

// Area of rough vertices that the camera sees, in m^2: the sum of the pixels' footprints at the ends of these paths.
double seen_area(const RenderContext& context, const RoughMaterials& rough_materials, const SeenOptions& options);

// The region within `reach` of what these paths see; with `gather_rays` > 0, of what that many BSDF-sampled rays from there
// see, and of what the paths see themselves if `with_ends`.
std::unique_ptr<VisibleRegion> find_seen(const RenderContext& context, const RoughMaterials& rough_materials,
                                         const SeenOptions& options, float reach, int gather_rays = 0, bool with_ends = false);

}  // namespace etendue
