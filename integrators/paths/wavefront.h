// Paths that are traced together, event by event, so that structures are asked for many rays at once.
#pragma once

#include "framework/transport/ray_tools.h"

#include <vector>

namespace etendue {

// Light that is gained if its shadow ray is free.
struct Gain {
  Rgb* to;
  Rgb radiance;
  void arrive(const Ray&) const { *to += radiance; }
};

// `PathState`: what a path under way carries to its next hit. `Gained`: a Gain, or what else arrives where a shadow ray is
// free.
template <class PathState, class Gained = Gain>
class Wavefront {
 public:
  void clear() {
    states_.clear();
    rays_.clear();
  }
  void start(const PathState& state, const Ray& ray) {
    states_.push_back(state);
    rays_.push_back(ray);
  }

  // Arrives once every path has been through its present event. What it points to must stay in place.
  void gain(const Gained& gained, const Ray& shadow_ray) {
    gains_.push_back(gained);
    shadow_rays_.push_back(shadow_ray);
  }

  // Calls meet(state, ray, hit, depth) for each path in turn, which sends state and ray on or returns false, until all have
  // ended. Paths have `depth` scattering events before their first hits. What they gain has come in when they meet what is
  // next.
  template <class Meet>
  void run(const RenderContext& context, int depth, const Meet& meet) {
    for (; !states_.empty(); ++depth) {
      hits_.resize(rays_.size());
      trace(context, rays_, hits_);
      gains_.clear();
      shadow_rays_.clear();
      std::size_t going_on = 0;
      for (std::size_t i = 0; i < states_.size(); ++i) {
        if (i + prefetched < hits_.size() && hits_[i + prefetched]) context.scene.prefetch_surface(hits_[i + prefetched]);
        PathState state = states_[i];
        Ray ray = rays_[i];
        if (!meet(state, ray, hits_[i], depth)) continue;
        states_[going_on] = state;
        rays_[going_on++] = ray;
      }
      states_.erase(states_.begin() + static_cast<std::ptrdiff_t>(going_on), states_.end());
      rays_.resize(going_on);
      for_unoccluded(context, shadow_rays_, [&](std::size_t i) { gains_[i].arrive(shadow_rays_[i]); });
    }
  }

 private:
  static constexpr std::size_t prefetched = 4;  // hits ahead: as long as memory takes

  std::vector<PathState> states_;
  std::vector<Ray> rays_;  // of the states
  std::vector<Hit> hits_;
  std::vector<Gained> gains_;
  std::vector<Ray> shadow_rays_;  // of the gains
};

}  // namespace etendue
