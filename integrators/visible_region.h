// Where photons matter: the parts of space within reach of points at which they will be gathered.
//
// A grid of bits over the scene's bounds. `mark` sets every cell that a ball touches, so that each photon within the ball is
// found to matter (and a few just outside): the region is never too small. What lies outside the bounds, on infinite planes,
// counts to the nearest cell. Marking is safe from many threads, and its result does not depend on their order.
#pragma once

#include "framework/integrator.h"
#include "integrators/photons.h"

#include <atomic>
#include <memory>

namespace etendue {

class VisibleRegion {
 public:
  // Cells are half as wide as `reach`, the typical radius, but at least 1/256 of the longest side of the bounds.
  VisibleRegion(const Bounds& bounds, float reach);

  void mark(const vec3& position, float radius);
  bool contains(const vec3& position) const;
  // Share of the cells that is marked.
  double share() const;

 private:
  uvec3 cell(const vec3& position) const;
  std::size_t bit(const uvec3& cell) const { return (static_cast<std::size_t>(cell.z) * size_.y + cell.y) * size_.x + cell.x; }

  vec3 lower_{0};
  float cells_per_metre_ = 1;
  uvec3 size_{1};
  std::vector<std::atomic<std::uint64_t>> bits_;
};

// What camera paths see of receivers, through whatever carries, and within `reach` of it. `gather_rays` > 0: what that many
// rays by the BSDF from there see instead. `samples` camera paths a pixel, of at most `max_depth` events.
struct SeenOptions {
  float reach = 0;
  int samples = 4;
  int gather_rays = 0;
  int max_depth = 64;
  SamplerKind sampler = SamplerKind::sobol;
};
std::unique_ptr<VisibleRegion> find_seen(const RenderContext& context, const Receivers& receivers, const SeenOptions& options);

}  // namespace etendue
