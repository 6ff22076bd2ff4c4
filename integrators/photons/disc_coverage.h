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
// weighted by the luminance of the path's throughput times the surface's albedo, lest cut discs that reflect little speak for
// whole ones beside them. On even light its only bias is that of a ratio, which falls as 1 / passes, whatever the radii and
// however they change ([Hey2002] computes the area geometrically; ratio of totals: [Cochran1977]). Black surfaces gather
// nothing.
//
// Only photons within 0.2 r of the tangent plane count, and likewise only surfaces that probes meet within it, weighted by the
// kernel at their distance over the cosine; of stacked surfaces a probe meets the upper one, but for smooth glass and sheets of
// other layers (framework/scene/layer.h), which it passes: photons lie beneath. So they do beneath what a wall hides from the
// point, as the upper side of a shelf whose lower one is near. Like a photon, what lies as far behind a kerb as that is high is
// seen over it. Surfaces that hold no photons or that the side test rejects do not count.
//
// Where surfaces are wide, nearly all discs are whole. So a pixel's disc is tried by one probe when it is first gathered, then
// in every 16th pass, by turns within blocks of 4 x 4 pixels; until one misses, discs count as whole. From then on the discs of
// its block, and from the next iteration on those of the blocks about it, are measured: by points of one low-discrepancy
// sequence, 16 in the first pass, then one per pass. Where part of the disc was found missing there are four per pass, and two
// from the 64th pass on; where 32 probes found all of it, one in every 16th pass. What the trials found does not count, so that
// the choice of what is measured biases nothing that is. On a mask, which a share of the probes passes while the others count
// for them, the sum scatters about the whole: to measure less where it happens to lie above would dim what is seen there.
#pragma once

#include "integrators/photons/photon_gather.h"

#include <atomic>

namespace etendue {

class DiscCoverage {
 public:
  struct Rules {
    Kernel kernel = Kernel::epanechnikov;
    bool side_test = true;
    SamplerKind sampler = SamplerKind::sobol;
  };

  DiscCoverage(const RoughMaterials& rough_materials, const Rules& rules, ivec2 resolution, std::size_t slots);

  static constexpr float flatness = 0.2f;  // of the radius
  static constexpr int block_side = 4;     // pixels

  // The kernel's disc of one gather of a pixel, with the weight that its photons have in the image.
  struct Disc {
    std::size_t slot;
    ivec2 pixel;
    GatherPoint at;
    float radius, weight;
  };
  // Those of an iteration's gathers in a map, of whole blocks.
  void measure(const RenderContext& context, const PhotonMap& map, std::uint32_t iteration, std::span<const Disc> discs);
  // The factor by which the photons' sum over all passes must be multiplied.
  double correction(std::size_t slot) const;

  // Estimates the covered share of the kernel's integral by one point of the disc, chosen with `u`.
  float probe(const RenderContext& context, const GatherPoint& at, float radius, const vec2& u, const NearWalls& walls) const;

 private:
  static constexpr double nearly_whole = 0.99;

  // A ray from above the disc to one of its points, and (distance from the centre / radius)^2 there.
  struct Aim {
    Ray ray;
    float x;
  };
  struct Slot {
    double whole = 0, covered = 0;
    std::uint32_t probes = 0, gathers = 0;  // trials are not among the probes
    bool masked = false;                    // a probe met a surface that lets rays through
  };
  // Holds what is measured at a time: discs, and their probes one disc after the other.
  struct Probes {
    struct OfDisc {
      const Disc* disc;
      std::uint32_t count;
    };
    std::vector<OfDisc> discs;
    std::vector<float> x;  // as Aim has it
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points;
  };
  // Points `first`, `first` + 1, … of the slot's sequence `dimension`.
  struct Points {
    std::uint32_t dimension, first, count;
  };

  std::size_t index_of(const ivec2& block) const { return static_cast<std::size_t>(block.y) * blocks_.x + block.x; }
  bool is_measured(const ivec2& block, std::uint32_t iteration) const;
  void trace_together(const RenderContext& context, const PhotonMap& map, Probes& probes);
  // body(u) for each point.
  template <class Body>
  void for_points(const RenderContext& context, const Disc& disc, const Points& points, const Body& body) const;
  Aim aim(const GatherPoint& at, float radius, const vec2& u) const;
  // The share that the probe adds for the surface that its ray met.
  float covered(const RenderContext& context, const GatherPoint& at, float radius, const Aim& aim, Hit hit, SurfacePoint point,
                const NearWalls& walls) const;

  const RoughMaterials& rough_materials_;
  Rules rules_;
  ivec2 blocks_;
  std::vector<Slot> slots_;
  std::vector<std::atomic<std::uint32_t>> missed_;  // by block: the first iteration in which a probe missed
};

}  // namespace etendue
