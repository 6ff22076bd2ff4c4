// Paths that are traced together, event by event, so that structures are asked for many rays at once.
#pragma once

#include "integrators/paths/surfaces.h"

#include <vector>

namespace etendue {

// `State`: what a path under way takes along to its next hit. `Gained`: what arrives where a shadow ray is free.
template <class State, class Gained = PathGain>
class Wavefront {
 public:
  void clear() {
    states_.clear();
    rays_.clear();
  }
  void start(const State& state, const Ray& ray) {
    states_.push_back(state);
    rays_.push_back(ray);
  }

  // Arrives once every path has been through its present event. What it points to must stay in place.
  void gain(const Gained& gained, const Ray& shadow_ray) {
    gains_.append() = gained;
    shadow_rays_.append() = shadow_ray;
  }

  // The hit of a point that meet was given, while it runs.
  const Hit& hit_of(const SurfacePoint& point) const { return hits_[static_cast<std::size_t>(&point - points_.data())]; }

  // Light samples that are worked out together, and come in before what else is gained.
  LightSamples& light_samples() { return light_samples_; }

  // Calls meet(state, ray, point, depth) for each path in turn, which sends state and ray on or returns false, until all have
  // ended; `point` is null where the ray met nothing, else it lies at ray.t_max. Paths have `depth` scattering events before
  // their first hits. What they gain has come in when they meet what is next.
  template <class Meet>
  void run(const RenderContext& context, int depth, const Meet& meet) {
    run(context, depth, meet, [&](LightSamples& lights) { lights.trace(context); });
  }
  // trace_lights(light_samples) does so after each event.
  template <class Meet, class TraceLights>
  void run(const RenderContext& context, int depth, const Meet& meet, const TraceLights& trace_lights) {
    run(context, depth, meet, trace_lights, [](const State&, const Ray&, std::size_t, int) { return true; });
  }
  // go_on(state, ray, i, depth) follows for the i-th of the paths that meet has not ended, to the same end as meet.
  template <class Meet, class Together, class GoOn>
  void run(const RenderContext& context, int depth, const Meet& meet, const Together& together, const GoOn& go_on) {
    for (; !states_.empty(); ++depth) {
      hits_.resize(rays_.size());
      trace(context, rays_, hits_);
      surfaces_at(context.scene, rays_, hits_, points_);
      gains_.clear();
      shadow_rays_.clear();
      keep([&](std::size_t i) {
        if (hits_[i]) rays_[i].t_max = hits_[i].t;
        return meet(states_[i], rays_[i], hits_[i] ? &points_[i] : nullptr, depth);
      });
      together(light_samples_);
      keep([&](std::size_t i) { return go_on(states_[i], rays_[i], i, depth); });
      for_unoccluded(context, std::span{shadow_rays_.data(), shadow_rays_.size()},
                     [&](std::size_t i) { gains_[i].arrive(shadow_rays_[i]); });
    }
  }

 private:
  template <class Kept>
  void keep(const Kept& kept) {
    kept_.clear();
    for (std::uint32_t i = 0; i < states_.size(); ++i)
      if (kept(i)) kept_.push_back(i);
    if (kept_.size() == states_.size()) return;
    // Only now: a ray that was just stored piece by piece is slow to copy.
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      states_[i] = states_[kept_[i]];
      rays_[i] = rays_[kept_[i]];
    }
    states_.erase(states_.begin() + static_cast<std::ptrdiff_t>(kept_.size()), states_.end());
    rays_.resize(kept_.size());
  }

  std::vector<State> states_;
  std::vector<Ray> rays_;  // of the states
  std::vector<std::uint32_t> kept_;
  std::vector<Hit> hits_;
  std::vector<SurfacePoint> points_;
  LightSamples light_samples_;
  GrowingList<Gained> gains_;
  GrowingList<Ray> shadow_rays_;  // of the gains
};

}  // namespace etendue
