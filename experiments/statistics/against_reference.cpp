#include "experiments/statistics/against_reference.h"

#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace etendue {

namespace {

constexpr double false_alarm_rate = 1e-3, indifferent_share = 1e-3;  // the latter of the image's mean

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

// The part of a difference that is not allowed, in units of its standard error; infinite where it is not a number.
double excess_in_errors(double difference, double allowed, double error) {
  if (!std::isfinite(difference)) return std::numeric_limits<double>::infinity();
  const double excess = std::abs(difference) - allowed;
  return excess > 0 ? excess / std::max(error, std::numeric_limits<double>::min()) : 0;
}

// The mean over a rectangle of pixels.
dvec3 colour_over(const Image& image, ivec2 begin, ivec2 end) {
  dvec3 sum(0);
  for (int y = begin.y; y < end.y; ++y)
    for (int x = begin.x; x < end.x; ++x) sum += image.at(x, y);
  return sum / (static_cast<double>(end.x - begin.x) * (end.y - begin.y));
}

// The mean over the channels, too.
double mean_over(const Image& image, ivec2 begin, ivec2 end) {
  const dvec3 colour = colour_over(image, begin, end);
  return (colour.x + colour.y + colour.z) / 3;
}

dvec3 channel_ratios(std::span<const Image> images, const Image& reference) {
  const dvec3 expected = colour_over(reference, ivec2(0), reference.size);
  dvec3 mean(0), ratio(1);
  for (const Image& image : images) mean += colour_over(image, ivec2(0), image.size) / static_cast<double>(images.size());
  for (int c = 0; c < 3; ++c)
    if (mean[c] != expected[c]) ratio[c] = mean[c] / expected[c];
  return ratio;
}

// Calls body(place, begin, end) for each block that has a pixel.
template <class Body>
void for_blocks(ivec2 size, const Body& body) {
  for (int y = 0; y < reference_blocks; ++y)
    for (int x = 0; x < reference_blocks; ++x) {
      const ivec2 begin = ivec2(x, y) * size / reference_blocks, end = (ivec2(x, y) + 1) * size / reference_blocks;
      if (begin.x < end.x && begin.y < end.y) body(ivec2(x, y), begin, end);
    }
}

void find_worst_block(std::span<const Image> images, const Image& reference, double level, AgainstReference& result) {
  for_blocks(reference.size, [&](ivec2 at, ivec2 begin, ivec2 end) {
    const double expected = mean_over(reference, begin, end);
    if (!(expected > 1e-3 * level)) return;
    const Moments m = moments(images.size(), [&](std::size_t i) { return mean_over(images[i], begin, end) / expected; });
    if (std::abs(m.mean - 1) <= std::abs(result.worst.ratio - 1)) return;
    result.worst = {at, m.mean, std::sqrt(m.variance / static_cast<double>(images.size()))};
  });
}

// Tests of means over rectangles of pixels.
struct MeanTest {
  std::span<const Image> images;
  const Image& reference;
  double level, samples;  // of the reference; per pixel

  // `each`: the level of this test. What no sample may have shown is allowed.
  double allowed(ivec2 begin, ivec2 end, double each) const {
    double brightest = 0;
    for (int y = begin.y; y < end.y; ++y)
      for (int x = begin.x; x < end.x; ++x)
        for (int c = 0; c < 3; ++c) brightest = std::max(brightest, reference.at(x, y)[c]);
    const double drawn = samples * (end.x - begin.x) * (end.y - begin.y), unseen = std::min(1.0, std::log(1 / each) / drawn);
    return indifferent_share * level + unseen * brightest;
  }
  double t(ivec2 begin, ivec2 end, double each) const {
    const auto count = static_cast<double>(images.size());
    const Moments m = moments(images.size(), [&](std::size_t i) { return mean_over(images[i], begin, end); });
    return excess_in_errors(m.mean - mean_over(reference, begin, end), allowed(begin, end, each),
                            std::max(std::sqrt(m.variance / count), 1e-12 * level));
  }
};

void test_means(const MeanTest& test, double group_level, AgainstReference& result) {
  const double freedom = static_cast<double>(test.images.size()) - 1;
  result.mean_t = test.t(ivec2(0), test.reference.size, group_level);
  result.mean_limit = student_t_quantile(1 - group_level / 2, freedom);
  if (test.level > 0) result.mean_allowed = test.allowed(ivec2(0), test.reference.size, group_level) / test.level;
  for_blocks(test.reference.size, [&](ivec2, ivec2, ivec2) { ++result.blocks; });
  const double each = sidak_level(group_level, result.blocks);
  result.block_limit = student_t_quantile(1 - each / 2, freedom);
  for_blocks(test.reference.size, [&](ivec2, ivec2 begin, ivec2 end) {
    const double t = test.t(begin, end, each);
    if (t > result.block_limit) ++result.blocks_failed;
    result.largest_block_t = std::max(result.largest_block_t, t);
  });
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

AgainstReference hold_against(std::span<const Image> images, const Image& reference, std::uint64_t samples) {
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
  result.channel_ratio = channel_ratios(images, reference);
  find_worst_block(images, reference, level, result);
  const double group_level = sidak_level(false_alarm_rate, 3);
  test_means({images, reference, level, static_cast<double>(samples)}, group_level, result);
  result.tests = 3 * reference.pixels.size();
  const double each = sidak_level(group_level, result.tests);
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
      const double allowed = indifferent_share * level + unseen * brightest_about(reference, at, c);
      const double t = excess_in_errors(difference, allowed, std::max(std::sqrt(m.variance / count), 1e-12 * level));
      if (t > result.limit) ++result.failed;
      if (t <= result.largest_t) continue;
      result.largest_t = t;
      result.largest_at = at;
    }
  return result;
}

Image averaged(const Image& image, int factor) {
  CHECK(image.size == image.size / factor * factor);
  Image mean(image.size / factor);
  for (int y = 0; y < mean.size.y; ++y)
    for (int x = 0; x < mean.size.x; ++x)
      mean.at(x, y) = colour_over(image, factor * ivec2(x, y), factor * ivec2(x + 1, y + 1));
  return mean;
}

std::string_view turned_against(const Image& image, const Image& reference) {
  constexpr double apart = 0.02;  // below it a difference is that of noise
  const auto blocks = [](const Image& of) {
    Image means{ivec2(reference_blocks)};
    for_blocks(of.size, [&](ivec2 at, ivec2 begin, ivec2 end) { means.at(at.x, at.y) = colour_over(of, begin, end); });
    return means;
  };
  const Image ours = blocks(image), theirs = blocks(reference);
  Image turned = theirs;
  const auto distance = [&](bool left_right, bool up_down) {
    for (int y = 0; y < reference_blocks; ++y)
      for (int x = 0; x < reference_blocks; ++x)
        turned.at(x, y) = theirs.at(left_right ? reference_blocks - 1 - x : x, up_down ? reference_blocks - 1 - y : y);
    return smape(ours, turned);
  };
  double least = distance(false, false) / 2;
  if (least < apart / 2) return {};
  std::string_view how;
  for (const auto& [name, left_right, up_down] :
       {std::tuple{"mirrored left to right", true, false}, {"upside down", false, true}, {"turned by half", true, true}})
    if (const double d = distance(left_right, up_down); d < least) least = d, how = name;
  return how;
}

}  // namespace etendue
