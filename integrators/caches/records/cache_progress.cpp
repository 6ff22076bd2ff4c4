#include "integrators/caches/records/cache_progress.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "framework/core/rng.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr std::uint64_t asking_pixels = 32;  // one in so many
constexpr int fewest_rays = 16;
constexpr int map_growth = 8;  // of a step
constexpr double steps_per_doubling = 10;
constexpr double pass_by_pass = 22;  // passes, from which on a step is one of them

double passes_of(double time) { return math::pow(time, 2.0 / 3); }
// Slightly larger, so that passes_of(time_of(passes)) is not less than passes.
double time_of(double passes) { return math::pow(passes + 1e-6, 1.5); }

// The first step that adds a whole pass.
double pass_step() { return std::ceil(steps_per_doubling * math::log2(time_of(pass_by_pass))); }

}  // namespace

double CacheProgress::time_at(std::uint32_t stage) const {
  const double step = std::max(0.0, static_cast<double>(stage) - overture_stages);
  return step < pass_step() ? math::exp2(step / steps_per_doubling) : time_of(pass_by_pass + step - pass_step());
}

double CacheProgress::passes_at(std::uint32_t stage, std::uint32_t spacing) const {
  return refines ? passes_of(time_at(spacing)) * (time_at(stage) / time_at(spacing)) : 1;
}

float CacheProgress::share_at(std::uint32_t stage) const {
  return refines && stage < overture_stages ? math::exp2(-2.0f * static_cast<float>(overture_stages - stage)) : 1;
}

std::uint32_t CacheProgress::map_steps() const {
  std::uint32_t steps = 0;
  if (refines)
    for (int left = map_photons; left >= 4 * first_map; left /= map_growth) ++steps;
  return steps;
}

std::uint32_t CacheProgress::map_steps_left(std::uint32_t stage) const {
  const std::uint32_t all = overture_stages + map_steps();
  return all - std::clamp(stage, overture_stages, all);
}

float CacheProgress::photon_share_at(std::uint32_t stage) const {
  float share = 1;
  for (std::uint32_t left = map_steps_left(stage); left > 0; --left) share /= map_growth;
  if (share < 1) share = std::max(share, static_cast<float>(first_map) / static_cast<float>(map_photons));
  return share * share_at(stage);
}

int CacheProgress::rays_at(std::uint32_t stage, int samples) const {
  return std::max(static_cast<int>(share_at(stage) * static_cast<float>(samples)), std::min(samples, fewest_rays));
}

float CacheProgress::accuracy_at(std::uint32_t stage) const {
  if (!refines) return accuracy;
  if (stage < overture_stages) return coarse * accuracy * math::exp2(0.5f * static_cast<float>(overture_stages - stage));
  return coarse * accuracy * static_cast<float>(math::pow(time_at(stage), -1.0 / 6));
}

double CacheProgress::weight_at(std::uint32_t stage) const {
  if (!refines) return 1;
  const double of_map = math::exp2(-2.0 * map_steps_left(stage));
  return of_map * (stage < overture_stages ? math::exp2(-3.0 * (overture_stages - stage)) : time_at(stage));
}

std::uint32_t CacheProgress::stage_after(std::uint32_t iterations) const {
  if (!refines) return overture_stages;
  const double time = 1 + iterations / 50.0;
  std::uint32_t stage = overture_stages;
  while (time_at(stage + 1) <= time) ++stage;
  return stage;
}

bool CacheProgress::asks(std::uint64_t pixel, std::uint32_t iteration) const {
  return hash_keys(pixel, iteration) % asking_pixels == 0;
}

void CachedLight::begin(std::uint32_t iteration, double weight) {
  weights_before_ += weight_;
  shared_ = asked_weight_ > 0 && weight > 0 ? math::pow(std::min(asked_weight_ / weight, 1.0), forgetting_) : 1;
  iteration_ = iteration;
  asked_weight_ = weight;
  // A filter's weights have a sum of one or more over a pixel's first samples if all count alike.
  weight_ = signed_.empty() ? weight : 1;
}

// The film averages equally, so it is given what makes its mean the weighted one.
void CachedLight::add(Film& film, ivec2 pixel, const Rgb& sampled, const Rgb& cached, const CachedError& error, double weight) {
  const std::size_t i = pixel_index(pixel, film.resolution());
  dvec3& sum = sums_[i];
  const auto show_signed = [&] { film.set(pixel, signed_[i] != 0 ? sum / signed_[i] : dvec3(0)); };
  if (!is_finite(sampled + cached)) {
    film.add(pixel, sampled + cached, iteration_);  // which counts it
    if (!signed_.empty()) show_signed();
    return;
  }
  const double t = iteration_ + 1.0;
  if (!scatter_.empty()) {
    Scatter& scatter = scatter_[i];
    const double value = weight != 0 ? luminance(sampled + cached) / weight : 0, step = value - scatter.mean;
    scatter.mean += step / t;
    scatter.squares += step * (value - scatter.mean);
    const double noise = weight_ * weight * error.noise;
    scatter.noise *= shared_;
    scatter.noise_squares += noise * (2 * scatter.noise + noise);
    scatter.noise += noise;
    scatter.bias += weight_ * weight * error.bias;
  }
  if (!signed_.empty()) {
    sum += dvec3(sampled) + dvec3(cached);
    signed_[i] += weight;
    show_signed();
    return;
  }
  const dvec3 mean_before = weights_before_ > 0 ? (t - 1) / weights_before_ * sum : dvec3(0);
  sum += weight_ * dvec3(cached);
  film.add(pixel, sampled + Rgb(t / (weights_before_ + weight_) * sum - mean_before), iteration_);
}

Image CachedLight::standard_error() const {
  CHECK_EQ(scatter_.size(), sums_.size());  // kept only under RenderContext::states_error
  Image image(resolution_);
  const double n = iteration_ + 1.0;
  for (std::size_t i = 0; i < scatter_.size(); ++i) {
    const Scatter& scatter = scatter_[i];
    // A signed filter's pixel is sum(w y) / sum(w), with w = 1 or -1. Its variance has the sum of (y - pixel)^2, which is that
    // about the mean of y and n times the square of the distance between the two.
    const double weights = signed_.empty() ? weights_before_ + weight_ : signed_[i], count = signed_.empty() ? n : signed_[i];
    if (!(weights > 0)) continue;
    const double off = signed_.empty() ? 0 : luminance(Rgb(sums_[i] / weights)) - scatter.mean;
    const double of_mean = n > 1 ? (scatter.squares + n * off * off) * n / (n - 1) / (count * count) : 0;
    const double bias = scatter.bias / weights;
    image.pixels[i] = dvec3(std::sqrt(of_mean + scatter.noise_squares / (weights * weights) + bias * bias));
  }
  return image;
}

}  // namespace etendue
