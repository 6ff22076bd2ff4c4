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

// `Walk`: what a path under way carries to its next hit. `Gained`: a Gain, or what else arrives where a shadow ray is free.
template <class Walk, class Gained = Gain>
class Wavefront {
 public:
  void clear() {
    walks_.clear();
    rays_.clear();
  }
  void start(const Walk& walk, const Ray& ray) {
    walks_.push_back(walk);
    rays_.push_back(ray);
  }

  // Arrives once every path has been through its present event. What it points to must stay in place.
  void gain(const Gained& gained, const Ray& shadow_ray) {
    gains_.push_back(gained);
    shadow_rays_.push_back(shadow_ray);
  }

  // Calls meet(walk, ray, hit, depth) for each path in turn, which sends walk and ray on or returns false, until all have
  // ended. Paths have `depth` scattering events before their first hits. What they gain has come in when they meet what is
  // next.
  template <class Meet>
  void run(const RenderContext& context, int depth, const Meet& meet) {
    for (; !walks_.empty(); ++depth) {
      hits_.resize(rays_.size());
      trace(context, rays_, hits_);
      gains_.clear();
      shadow_rays_.clear();
      std::size_t going_on = 0;
      for (std::size_t i = 0; i < walks_.size(); ++i) {
        if (i + prefetched < hits_.size() && hits_[i + prefetched]) context.scene.prefetch_surface(hits_[i + prefetched]);
        Walk walk = walks_[i];
        Ray ray = rays_[i];
        if (!meet(walk, ray, hits_[i], depth)) continue;
        walks_[going_on] = walk;
        rays_[going_on++] = ray;
      }
      walks_.erase(walks_.begin() + static_cast<std::ptrdiff_t>(going_on), walks_.end());
      rays_.resize(going_on);
      for_unoccluded(context, shadow_rays_, [&](std::size_t i) { gains_[i].arrive(shadow_rays_[i]); });
    }
  }

 private:
  static constexpr std::size_t prefetched = 4;  // hits ahead: as long as memory takes

  std::vector<Walk> walks_;
  std::vector<Ray> rays_;  // of the walks
  std::vector<Hit> hits_;
  std::vector<Gained> gains_;
  std::vector<Ray> shadow_rays_;  // of the gains
};

}  // namespace etendue
