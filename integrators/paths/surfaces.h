// Surfaces that the rays of a wave met, and light samples at them, in the lanes of the processor: for methods that go on from
// there path by path.
#pragma once

#include "framework/core/growing_list.h"
#include "integrators/paths/path_event.h"
#include "integrators/paths/runs.h"

namespace etendue {

// points[i] becomes the surface that ray i met, if it met one. The buffer grows only.
void surfaces_at(const Scene& scene, std::span<const Ray> rays, std::span<const Hit> hits, std::vector<SurfacePoint>& points);

// Queries to the BSDFs of a wave, which are answered together.
class BsdfBatch {
 public:
  // The point must stay in place until the query is answered; `other` as BsdfQuery has it.
  void ask(const SurfacePoint& point, const vec3& wo, const vec3& other) {
    begin();
    BsdfQuery& query = queries_.append();
    query.point = &point;
    query.wo = wo;
    query.other = other;
  }
  // Answers to what was asked since the last ones, in that order; they and the points stay until more is asked.
  const BsdfPair* pairs(const Scene& scene, TransportMode mode) {
    answer(scene, mode, &pairs_, nullptr);
    return pairs_.data();
  }
  const ReversibleSample* samples(const Scene& scene, TransportMode mode) {
    answer(scene, mode, nullptr, &samples_);
    return samples_.data();
  }
  const SurfacePoint& point(std::size_t query) const { return *queries_[query].point; }

 private:
  void begin() {
    if (answered_) queries_.clear();
    answered_ = false;
  }
  void answer(const Scene& scene, TransportMode mode, std::vector<BsdfPair>* pairs, std::vector<ReversibleSample>* samples);

  bool answered_ = false;
  GrowingList<BsdfQuery> queries_;
  std::vector<BsdfPair> pairs_;
  std::vector<ReversibleSample> samples_;
  Runs runs_;
};

// Light samples of a wave, none of which is MIS-weighted: the mean of each is the whole direct light (MisMode::light).
class LightSamples {
 public:
  // At a surface with a rough lobe, towards wo. The path's sampler draws the sample, and its radiance gains what comes of it,
  // once they are traced. Till then the path must stay in place.
  void add(const SurfacePoint& point, const vec3& wo, const Rgb& throughput, PathSample& path);
  void trace(const RenderContext& context) {
    const std::size_t gained = draw(context, false);
    arrived(context, gained, [&](std::size_t i) { gains_[i].arrive(shadow_rays_[i]); });
  }
  // The caller weights them: arrive(gain, densities, shadow_ray) for each that nothing blocks.
  template <class Arrive>
  void trace(const RenderContext& context, const Arrive& arrive) {
    const std::size_t gained = draw(context, true);
    arrived(context, gained, [&](std::size_t i) { arrive(gains_[i], densities_[i], shadow_rays_[i]); });
  }

 private:
  template <class Body>
  void arrived(const RenderContext& context, std::size_t gained, const Body& body) const {
    for_unoccluded(context, std::span(shadow_rays_).first(gained), body);
  }
  // How many bring something.
  std::size_t draw(const RenderContext& context, bool densities);

  std::vector<PathState> states_;
  std::vector<Ray> rays_;  // that found the points
  std::vector<SurfacePoint> points_;
  std::vector<PathGain> gains_;
  std::vector<Ray> shadow_rays_;
  std::vector<LightDensities> densities_;
  Runs runs_;
};

}  // namespace etendue
