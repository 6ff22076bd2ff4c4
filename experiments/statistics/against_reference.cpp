#include "experiments/statistics/against_reference.h"

#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace etendue {

namespace {

constexpr double false_alarm_rate = 1e-3;

struct Moments {
  double mean = 0, variance = 0;  // of one value, unbiased
};

template <class Value>
Moments moments(std::size_t count, const Value& value) {
  Moments m;
  for (std::size_t i = 0; i < count; ++i) m.mean += value(i) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i)
    m.variance += (value(i) - m.mean) * (value(i) - m.mean) / static_cast<double>(count - 1);
  return m;
}

// The mean over a rectangle of pixels and the channels.
double mean_over(const Image& image, ivec2 begin, ivec2 end) {
  double sum = 0;
  for (int y = begin.y; y < end.y; ++y)
    for (int x = begin.x; x < end.x; ++x) sum += image.at(x, y).x + image.at(x, y).y + image.at(x, y).z;
  return sum / (3.0 * (end.x - begin.x) * (end.y - begin.y));
}

void find_worst_block(std::span<const Image> images, const Image& reference, double level, AgainstReference& result) {
  for (int y = 0; y < reference_blocks; ++y)
    for (int x = 0; x < reference_blocks; ++x) {
      const ivec2 begin = ivec2(x, y) * reference.size / reference_blocks,
                  end = (ivec2(x, y) + 1) * reference.size / reference_blocks;
      if (begin.x == end.x || begin.y == end.y) continue;
      const double expected = mean_over(reference, begin, end);
      if (!(expected > 1e-3 * level)) continue;
      const Moments m = moments(images.size(), [&](std::size_t i) { return mean_over(images[i], begin, end) / expected; });
      if (std::abs(m.mean - 1) < std::abs(result.worst.ratio - 1) && result.worst.ratio != 0) continue;
      result.worst = {{x, y}, m.mean, std::sqrt(m.variance / static_cast<double>(images.size()))};
    }
}

// The largest value of a channel of the reference among a pixel and its neighbours.
double brightest_about(const Image& reference, ivec2 at, int channel) {
  double most = 0;
  for (int y = std::max(at.y - 1, 0); y <= std::min(at.y + 1, reference.size.y - 1); ++y)
    for (int x = std::max(at.x - 1, 0); x <= std::min(at.x + 1, reference.size.x - 1); ++x)
      most = std::max(most, reference.at(x, y)[channel]);
  return most;
}

}  // namespace

AgainstReference hold_against(std::span<const Image> images, const Image& reference, std::uint64_t samples,
                              double indifference) {
  CHECK_GT(samples, std::uint64_t{0});
  CHECK_GT(images.size(), std::size_t{1});
  for (const Image& image : images) CHECK(image.size == reference.size);
  AgainstReference result;
  const auto count = static_cast<double>(images.size());
  const double level = mean_over(reference, ivec2(0), reference.size);
  const Moments whole =
      moments(images.size(), [&](std::size_t i) { return mean_over(images[i], ivec2(0), reference.size) / level; });
  result.ratio = whole.mean;
  result.ratio_error = std::sqrt(whole.variance / count);
  find_worst_block(images, reference, level, result);
  result.tests = 3 * reference.pixels.size();
  const double each = sidak_level(false_alarm_rate, result.tests);
  const double unseen = std::min(1.0, std::log(1 / each) / static_cast<double>(samples));
  result.limit = student_t_quantile(1 - each / 2, count - 1);
  for (std::size_t p = 0; p < reference.pixels.size(); ++p)
    for (int c = 0; c < 3; ++c) {
      const double expected = reference.pixels[p][c];
      const Moments m = moments(images.size(), [&](std::size_t i) { return images[i].pixels[p][c]; });
      const double difference = m.mean - expected,
                   scale = static_cast<double>(result.tests) * (expected * expected + relmse_epsilon);
      result.relmse_of_bias += (difference * difference - m.variance / count) / scale;
      result.relmse_of_noise += m.variance / scale;
      const ivec2 at{static_cast<int>(p) % reference.size.x, static_cast<int>(p) / reference.size.x};
      const double allowed = indifference * level + unseen * brightest_about(reference, at, c);
      const double excess = std::max(0.0, std::abs(difference) - allowed);
      const double t = excess > 0 ? excess / std::max(std::sqrt(m.variance / count), 1e-12 * level) : 0;
      if (t > result.limit || !std::isfinite(difference)) ++result.failed;
      if (t <= result.largest_t) continue;
      result.largest_t = t;
      result.largest_at = at;
    }
  return result;
}

}  // namespace etendue
