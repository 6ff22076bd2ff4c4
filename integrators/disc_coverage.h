// How much of the kernel's discs is surface, measured along with the photons: against loss at edges, where one ray must do.
//
// A density estimate divides by the whole disc though part of it may be off the surface: next to nothing is left of a table's
// edge or its legs where photons are few and discs wide. integrators/kernel_domain.h finds the part that is there point by
// point, with some hundred rays. A progressive method looks at a pixel again in every pass, so here a few random probes a pass
// do: rays through points of the disc, distributed as the kernel, down to the surface. The pixel's image is then the ratio of
// totals over all passes,
//
//   sum of what photons make  *  sum of weights / sum of weights times the share of probes that met a surface,
//
// with the luminance of the path's throughput for weight: on even light, without bias but for that of a ratio, which falls as
// 1 / passes, at any radii, however they change ([Hey2002] has the area by geometry, [Cochran1977] the ratio of totals).
//
// Photons count within 0.2 r of the tangent plane alone, and so do the surfaces that probes meet, by the kernel at their own
// distance over the cosine; of surfaces above each other the upper one is met. What photons cannot lie on or the side test
// refuses does not count. Light from behind a wall on the same floor leaks as before.
//
// Probes are points of one low-discrepancy sequence a pixel: 16 in its first pass, then one; where part of the disc was found
// missing four, two from the 64th on; where 32 have found all of it, one in every 16th pass.
#pragma once

#include "integrators/photon_gather.h"

namespace etendue {

class DiscCoverage {
 public:
  struct Rules {
    Kernel kernel = Kernel::epanechnikov;
    bool side_test = true;
    SamplerKind sampler = SamplerKind::sobol;
  };

  DiscCoverage(const Receivers& receivers, const Rules& rules, std::size_t slots)
      : receivers_(receivers), rules_(rules), slots_(slots) {}

  static bool near_plane(const vec3& offset, const vec3& normal, float radius) {
    return std::abs(glm::dot(offset, normal)) <= flatness * radius;
  }
  // The kernel's disc of one gather, with the weight that its photons have in the image.
  void measure(const RenderContext& context, std::size_t slot, const GatherPoint& at, float radius, float weight);
  // What the photons' sum over all passes is to be multiplied by.
  double correction(std::size_t slot) const;

  // Of the kernel's integral, by one point of the disc chosen with `u`.
  float probe(const RenderContext& context, const GatherPoint& at, float radius, const vec2& u) const;

 private:
  static constexpr float flatness = 0.2f;  // of the radius
  static constexpr double nearly_whole = 0.99;

  struct Slot {
    double whole = 0, covered = 0;
    std::uint32_t probes = 0, gathers = 0;
  };

  const Receivers& receivers_;
  Rules rules_;
  std::vector<Slot> slots_;
};

}  // namespace etendue
