#include "integrators/progressive/adaptive_bandwidth.h"

#include "framework/core/elementary.h"

namespace etendue {

static_assert(RadiusPolicy<AdaptiveBandwidth>);

namespace {

// Mean over the disc of `f` of x = (distance / radius)^2.
template <class F>
float disc_mean(const F& f) {
  constexpr int steps = 4096;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += f((static_cast<float>(i) + 0.5f) / steps);
  return static_cast<float>(sum / steps);
}

constexpr float narrowest = 0.15f;  // of r_1, at the first pass

}  // namespace

void AdaptiveBandwidth::Observed::begin(const GatherDisc& disc, const GatherPoint&, const Rgb& throughput) {
  throughput_ = throughput;
  radius_squared_ = square(disc.radius);
  per_reach_squared_ = 1 / square(disc.reach);
}

// kappa: bias over r^2 laplacian, 1/8 for the box; roughness: mean of the squared kernel over that of the box.
AdaptiveBandwidth::AdaptiveBandwidth(InitialRadii radii, Kernel kernel)
    : kappa_(disc_mean([&](float x) { return 0.25f * x * kernel_shape(kernel, x); })),
      roughness_(disc_mean([&](float x) { return square(kernel_shape(kernel, x)); })) {
  pixels_.reserve(radii.size());
  for (const float r : radii) pixels_.push_back({r});
}

GatherDisc AdaptiveBandwidth::disc(const GatherSite& site) const {
  const Pixel& p = pixels_[site.pixel];
  const float n = p.passes + 1, widest = p.first * math::pow(n, -0.1f);
  if (p.passes == 0) return GatherDisc(widest);
  const double laplacian_squared = (p.laplacian * p.laplacian - p.laplacian_variance) / square(p.passes);
  const double squared_bias = 6 * square(kappa_) * laplacian_squared * n;
  const double c = p.c / p.passes;
  const float best = squared_bias > 0 ? static_cast<float>(math::pow(c / squared_bias, 1.0 / 6)) : widest;
  return {std::clamp(best, narrowest * p.first * math::pow(n, -1.0f / 6), widest), widest};
}

void AdaptiveBandwidth::update(std::size_t pixel, std::uint32_t, const Observed& observed) {
  Pixel& p = pixels_[pixel];
  const double per_reach_squared = observed.per_reach_squared_, factor = 48 * inv_pi * per_reach_squared * per_reach_squared;
  p.passes += 1;
  p.c += observed.squares * (roughness_ * square(inv_pi)) / observed.radius_squared_;
  p.laplacian += observed.laplacian * factor;
  p.laplacian_variance += observed.laplacian_variance * (factor * factor);
}

}  // namespace etendue
