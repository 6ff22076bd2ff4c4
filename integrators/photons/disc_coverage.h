// How much of a kernel's discs is covered by the surface, measured while photons are gathered: it corrects the loss of light at
// edges with about one ray per pass.
//
// A density estimate divides by the whole disc although part of it may be off the surface: where photons are few and discs
// wide, a table's edges and legs lose nearly all their light. integrators/photons/kernel_domain.h finds the covered part at
// each point with some hundred rays. A progressive method returns to a pixel in every pass, so a few random probes per pass
// suffice: rays through points of the disc, distributed as the kernel, down to the surface. The pixel's image is then the ratio
// of totals over all passes,
//
//   sum of what photons make  *  sum of weights / sum of weights times the share of probes that met a surface,
//
// weighted by the luminance of the path's throughput. On even light its only bias is that of a ratio, which falls as 1 /
// passes, whatever the radii and however they change ([Hey2002] computes the area geometrically; ratio of totals:
// [Cochran1977]).
//
// Only photons within 0.2 r of the tangent plane count, and likewise only surfaces that probes meet within it, weighted by the
// kernel at their distance over the cosine; of stacked surfaces a probe meets the upper one, but for smooth glass, which it
// passes: photons lie beneath. Surfaces that hold no photons or that the side test rejects do not count, nor what a wall hides
// from the point.
//
// The probes of a pixel are points of one low-discrepancy sequence: 16 in the first pass, then one per pass. Where part of the
// disc was found missing there are four per pass, and two from the 64th pass on; where 32 probes found all of it, one in every
// 16th pass.
#pragma once

#include "integrators/photons/photon_gather.h"

namespace etendue {

class DiscCoverage {
 public:
  struct Rules {
    Kernel kernel = Kernel::epanechnikov;
    bool side_test = true;
    SamplerKind sampler = SamplerKind::sobol;
  };

  DiscCoverage(const RoughMaterials& rough_materials, const Rules& rules, std::size_t slots)
      : rough_materials_(rough_materials), rules_(rules), slots_(slots) {}

  static constexpr float flatness = 0.2f;  // of the radius

  // The kernel's disc of one gather in a map, with the weight that its photons have in the image.
  void measure(const RenderContext& context, std::size_t slot, const PhotonMap& map, const GatherPoint& at, float radius,
               float weight);
  // The factor by which the photons' sum over all passes must be multiplied.
  double correction(std::size_t slot) const;

  // Estimates the covered share of the kernel's integral by one point of the disc, chosen with `u`.
  float probe(const RenderContext& context, const GatherPoint& at, float radius, const vec2& u, const NearWalls& walls) const;

 private:
  static constexpr double nearly_whole = 0.99;

  struct Slot {
    double whole = 0, covered = 0;
    std::uint32_t probes = 0, gathers = 0;
  };

  const RoughMaterials& rough_materials_;
  Rules rules_;
  std::vector<Slot> slots_;
};

}  // namespace etendue
