// Caustics for methods whose light comes along paths from the camera ([Jensen1996]): what reaches a rough vertex by way of
// specular-like ones is gathered from a map of caustic photons there, and left out where a path meets a light behind such
// surfaces.
//
// With S for a delta lobe and R for any other,
//
//   caustic    L S+ R   the map, at every R that a path meets, whether seen by the camera or by what fills a cache
//   the rest   L R, and L S* E of the camera's own path: light samples and the emission that paths meet
//
// so that nothing is counted twice: a path that has left an R, and since then has followed delta lobes alone, counts no
// emission that it meets. Photons resolve the core of a narrow rough lobe badly, where paths find lights easily: there the
// two are parted by direction, as photons.h says of lobe tails. But for lights that no ray can meet photons are the only way,
// so that in scenes with such lights they are gathered in all directions.
//
// Every iteration has new photons, so that their noise averages out. Their kernels shrink as iteration i's disc has the share
// (i + 1)^-(1/3) of the one that holds the k nearest (alpha = 2/3 of [Knaus2011], the best rate of this form
// [Kaplanyan2013]): light is blurred by the kernel, which vanishes with it. Where photons lie evenly, kernels hold more than four
// times as many (photon_gather.h). They are divided by what the point sees of them, lest light be lost at edges.
//
// Where photons have lit nothing that was looked at, iterations have them less and less often (RareEmission).
#pragma once

#include "integrators/paths/path.h"
#include "integrators/photons/photon_maps.h"

#include <algorithm>
#include <atomic>
#include <optional>

namespace etendue {

struct CausticParams {
  CausticMap caustic_map = CausticMap::where_needed;
  int caustic_photons = 0;
};

template <class Visitor>
void describe_caustics(Visitor& v, CausticParams& p) {
  v.choice("caustic_map", p.caustic_map,
           "of photons that come by way of specular surfaces; auto: where paths find their light too seldom; off: paths meet "
           "lights behind them by chance");
  v.integer("caustic_photons", p.caustic_photons, 0, 2000000000, "photons",
            "emitted for that map in every iteration; 0: three for each pixel, at least 20,000");
}

// As long as v emissions have brought nothing, the next one takes place with a chance of 1 / v and counts v times. The mean is
// that of emissions in every iteration, and n iterations have some sqrt(2 n). Once one has brought something, all iterations
// have theirs.
class RareEmission {
 public:
  // The weight of an emission now; 0: there is none. `u`: uniform in [0, 1).
  float weight(float u) const { return u * expected() < 1 ? expected() : 0; }
  void emitted(bool brought) {
    found_ = found_ || brought;
    ++emissions_;
  }
  float chance() const { return 1 / expected(); }

 private:
  float expected() const { return found_ ? 1.0f : static_cast<float>(std::max(emissions_, 1)); }
  bool found_ = false;
  int emissions_ = 0;
};

class CausticLight final : public PathCaustics {
 public:
  // `narrow`: a GGX alpha above which no lobe's core is left to paths.
  CausticLight(const RenderContext& context, int caustic_photons, int max_depth, SamplerKind sampler, float narrow = infinity);

  double photons() const { return emission_.chance() * maps_.caustic_photons(); }  // emitted in an iteration, as expected
  // The photons of an iteration.
  void trace(RenderContext& context, std::uint32_t iteration);

  bool gathers_at(std::uint32_t material) const override { return maps_.rough_materials()(material); }
  bool leaves(std::uint32_t material, float pdf_bsdf) const override {
    return lobes_ && lobes_->has_tails(material) && pdf_bsdf >= lobes_->tail_density();
  }
  Rgb reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                int depth) const override {
    if (weight_ == 0) return Rgb(0);
    const bool of_tails = lobes_ && lobes_->has_tails(point.material);
    const float tail_density = of_tails ? lobes_->tail_density() : infinity;
    const Rgb light = weight_ * maps_.caustics(context, point, bsdf, wo, max_depth_ - depth - 1, tail_density);
    if (!is_black(light) && !brought_.load(std::memory_order_relaxed)) brought_.store(true, std::memory_order_relaxed);
    return light;
  }

 private:
  PhotonMaps maps_;
  RareEmission emission_;
  float weight_ = 0;                           // of the latest photons; 0: there are none
  mutable std::atomic<bool> brought_ = false;  // to anything that was looked at
  int max_depth_;
  std::optional<RoughMaterials> lobes_;  // whose cores are left to paths; none: no lobe's
};

// Notes what a camera path has been through, to tell which emission the map holds.
class CausticChain {
 public:
  bool holds_emission() const { return by_map_ && by_delta_; }
  // The path leaves a vertex, by a delta lobe or in a direction of this density. Without a map it never holds anything.
  void leave(const CausticLight* caustics, std::uint32_t material, bool by_delta, float pdf_bsdf) {
    by_delta_ = by_delta;
    if (!by_delta) by_map_ = caustics != nullptr && !caustics->leaves(material, pdf_bsdf);
  }

 private:
  bool by_map_ = false, by_delta_ = false;
};

}  // namespace etendue
