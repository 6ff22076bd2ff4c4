#include "integrators/paths/sample_shares.h"

#include "framework/core/check.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace etendue {

namespace {

constexpr double smooth_outlines = 0.01;  // relative deviation below which one sample is enough where few pixels scatter
constexpr double worth = 0.5;  // of the variance, above which sharing leaves so much that points in one sequence do better
constexpr double dark = 0.25;  // of the image's mean: deviations of darker pixels are relative to this

// Numbers that a span has for a pixel's samples, in bits: two million iterations of the most samples.
constexpr int span_bits = 26;
static_assert(2 * SampleShares::most_first * SampleShares::most <= 1u << span_bits);

// Samples of each pixel where all take as many.
std::uint32_t alike(float extra) { return 1 + static_cast<std::uint32_t>(std::min(extra, SampleShares::most - 1.0f)); }

}  // namespace

SampleShares::SampleShares(ivec2 resolution, float extra, std::uint32_t first, bool measures)
    : resolution_(resolution), extra_(extra), first_(first * most) {
  CHECK_LE(first, most_first);
  const auto pixels = static_cast<std::size_t>(resolution.x) * resolution.y;
  next_.assign(pixels, first_);
  even_ = alike(extra);
  count_.assign(pixels, even_);
  if (!(extra > 0) && !measures) return;
  moments_.resize(pixels);
  deviation_.resize(pixels);
}

void SampleShares::begin_with_one() {
  even_ = 1;
  std::ranges::fill(count_, 1);
}

void SampleShares::add(std::size_t pixel, float luminance) {
  if (moments_.empty() || !std::isfinite(luminance)) return;
  Moments& m = moments_[pixel];
  m.count += 1;
  m.sum += luminance;
  m.squares += square(static_cast<double>(luminance));
}

float SampleShares::relative_square(std::size_t pixel, float error) const {
  const Moments& m = moments_[pixel];
  const double mean = m.count > 0 ? m.sum / m.count : 0, whole = mean * mean + floor_;
  return whole > 0 ? static_cast<float>(square(static_cast<double>(error)) / whole) : 0;
}

// Relative standard deviations, each over a pixel and its neighbours.
void SampleShares::measure() {
  const auto width = static_cast<std::size_t>(resolution_.x);
  double total = 0;
  for (const Moments& m : moments_) total += m.count > 0 ? m.sum / m.count : 0;
  floor_ = square(dark * known_mean_.value_or(total / static_cast<double>(moments_.size()))) + 1e-30;
  parallel_for(static_cast<std::size_t>(resolution_.y), 8, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < resolution_.x; ++x) {
      double pixels = 0, sum = 0, squares = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, resolution_.y - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, resolution_.x - 1); ++u) {
          const Moments& m = moments_[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)];
          if (!(m.count > 0)) continue;
          pixels += 1;
          sum += m.sum / m.count;
          squares += m.squares / m.count;
        }
      const std::size_t i = row * width + static_cast<std::size_t>(x);
      const Moments& here = moments_[i];
      if (!(pixels > 0 && here.count > 0)) {
        deviation_[i] = 0;
        continue;
      }
      const double mean = here.sum / here.count, variance = squares / pixels - square(sum / pixels);
      deviation_[i] = static_cast<float>(std::sqrt(std::max(variance, 0.0) / (mean * mean + floor_)));
    }
  });
}

void SampleShares::end_iteration() {
  for (std::size_t i = 0; i < next_.size(); ++i) {
    next_[i] += count_[i];
    samples_ += count_[i];
  }
  ++iterations_;
  if (moments_.empty() || !std::has_single_bit(iterations_)) return;
  measure();
  const bool seen_within = samples_ > next_.size();  // after one a pixel only neighbours tell, which a gradient parts too
  if (extra_ > 0 && seen_within) choose_numbers();
  if (extra_ > 0 && expects_common_) remember();
  variance_ = iteration_variance();
}

void SampleShares::choose_numbers() {
  const std::uint32_t even = common_over_own() > common ? 1 : wanted_of_each();
  if (even == even_ && even > 0) return;  // points of one sequence go on evening each other out
  even_ = even;
  if (even == 0)
    share_out();
  else
    std::fill(count_.begin(), count_.end(), even);
  std::fill(next_.begin(), next_.end(), (++span_ << span_bits) + first_);
}

void SampleShares::remember() {
  before_.resize(moments_.size());
  for (std::size_t i = 0; i < before_.size(); ++i)
    before_[i] = {static_cast<float>(moments_[i].count),
                  static_cast<float>(moments_[i].sum / std::max(moments_[i].count, 1.0))};
}

// The variance that all samples of an iteration share over that of one sample, by how the differences between the two halves of
// the iterations go together in neighbouring pixels. What reaches over a pixel or less is not counted.
double SampleShares::common_over_own() const {
  if (before_.empty()) return 0;
  std::vector<float> differences(moments_.size());
  double shared = 0, all = 0, pairs = 0, first = 0, second = 0;
  for (std::size_t i = 0; i < moments_.size(); ++i) {
    const Moments& m = moments_[i];
    const Mean& before = before_[i];
    const double later = m.count - before.count;
    if (!(before.count > 0 && later > 0)) continue;
    const double mean = m.sum / m.count;
    const double difference = (m.sum - static_cast<double>(before.count) * before.mean) / later - before.mean;
    differences[i] = static_cast<float>(difference / std::sqrt(mean * mean + floor_));
    all += square(static_cast<double>(differences[i]));
    first += before.count;
    second += later;
  }
  const auto width = static_cast<std::size_t>(resolution_.x);
  for (std::size_t i = 0; i < differences.size(); ++i)
    for (const std::size_t next : {i + 1, i + width}) {
      if (next >= differences.size() || (next == i + 1 && next % width == 0)) continue;
      shared += differences[i] * differences[next];
      pairs += 1;
    }
  const auto pixels = static_cast<double>(moments_.size());
  if (!(shared > 0 && all > 0 && first > 0 && second > 0)) return 0;
  const double correlation = std::min(shared / pairs / (all / pixels), 0.999);
  // Each half has as many iterations, and the means of their samples differ by the variance of one sample times this.
  const double own = pixels / first + pixels / second, common = 2.0 / (0.5 * iterations_);
  return correlation / (1 - correlation) * own / common;
}

// Shared out, n samples leave (sum of sigma)^2 / n of the variance, and alike the pixels' number x (sum of sigma^2) / n.
std::uint32_t SampleShares::wanted_of_each() const {
  const auto pixels = static_cast<double>(deviation_.size());
  double sum = 0, squares = 0, within = 0;
  for (std::size_t i = 0; i < deviation_.size(); ++i) {
    const double d = deviation_[i];
    sum += d;
    squares += d * d;
    within += sample_variance(i);
  }
  const bool shared = square(sum) < worth * pixels * squares;  // a few pixels scatter: outlines, in large images
  if (within < square(shared ? smooth_outlines : smooth) * pixels) return 1;
  return shared ? 0 : alike(extra_);
}

// Relative, by the scatter within the pixel; by that over neighbours as well while the pixel has had one sample.
double SampleShares::sample_variance(std::size_t pixel) const {
  const Moments& m = moments_[pixel];
  if (!(m.count > 1)) return square(static_cast<double>(deviation_[pixel]));
  const double mean = m.sum / m.count;
  return std::max(m.squares / m.count - mean * mean, 0.0) * m.count / (m.count - 1) / (mean * mean + floor_);
}

double SampleShares::iteration_variance() const {
  double sum = 0;
  for (std::size_t i = 0; i < moments_.size(); ++i) sum += sample_variance(i) / count_[i];
  return sum / static_cast<double>(moments_.size());
}

void SampleShares::share_out() {
  // Samples beyond a pixel's largest number go to the others; numbers are whole.
  double per_deviation = 0;
  const double extras = static_cast<double>(extra_) * static_cast<double>(count_.size());
  for (int round = 0; round < 4; ++round) {
    double sum = 0, cut = 0;
    for (const float d : deviation_)
      if (per_deviation * d >= most - 1.0)
        cut += most - 1;
      else
        sum += d;
    if (!(sum > 0) || !(extras > cut)) break;
    per_deviation = (extras - cut) / sum;
  }
  for (std::size_t i = 0; i < count_.size(); ++i)
    count_[i] = 1 + static_cast<std::uint32_t>(std::min(per_deviation * deviation_[i], most - 1.0));
}

}  // namespace etendue
