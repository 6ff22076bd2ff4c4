#include "experiments/statistics/agreement.h"

#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace etendue {

namespace {

constexpr int grid = 8;
constexpr std::size_t region_count = 1 + grid * grid;

// Calls `use(region, pixel)` for each region that holds a pixel: the image and one block.
template <typename Use>
void for_each_region_pixel(const Image& image, const Use& use) {
  for (int y = 0; y < image.size.y; ++y)
    for (int x = 0; x < image.size.x; ++x) {
      const int block = 1 + (y * grid / image.size.y) * grid + x * grid / image.size.x;
      for (const int region : {0, block}) use(static_cast<std::size_t>(region), image.at(x, y));
    }
}

struct Sample {
  double mean = 0, variance_of_mean = 0;
};

Sample sample_of(const BatchStatistics& statistics, std::size_t region, int channel) {
  const auto n = static_cast<double>(statistics.batches());
  Sample sample;
  for (const auto& batch : statistics.regions()) sample.mean += batch[region][channel] / n;
  for (const auto& batch : statistics.regions())
    sample.variance_of_mean += (batch[region][channel] - sample.mean) * (batch[region][channel] - sample.mean) / (n * (n - 1));
  return sample;
}

// Compares one region and channel. All but `region` and `n` are in units of radiance.
struct Comparison {
  std::size_t region = 0;
  double difference = 0;  // of the first from the second
  double excess = 0;      // of its size over the margin
  double limit = 0;       // of the t-test
  double allowance = 0;   // for paths that the darker estimator has not seen
  double n = 0;           // samples per pixel of the darker one

  double t_ratio() const { return ratio(limit); }
  double conviction() const { return ratio(limit + allowance); }
  // The multiple of the samples at which limit and allowance would have fallen to the excess: one falls as the root of the
  // samples, the other as their inverse.
  double times_the_samples() const { return times_until(excess); }
  double times_until(double radiance) const {
    const double root = (limit + std::sqrt(limit * limit + 4 * allowance * radiance)) / (2 * radiance);
    return root * root;
  }

 private:
  double ratio(double of) const { return excess <= 0 ? 0 : of > 0 ? excess / of : std::numeric_limits<double>::infinity(); }
};

// Compares all regions and channels, and keeps the worst ones.
class Comparisons {
 public:
  Comparisons(const BatchStatistics& a, const BatchStatistics& b, const AgreementOptions& options)
      : a_(a),
        b_(b),
        brightest_(std::max({options.brightest, 2 * a.rare_value(), 2 * b.rare_value()})),
        tests_(3 * static_cast<std::size_t>(std::ranges::count_if(a.pixels(), [](auto n) { return n > 0; }))),
        level_(sidak_level(options.false_alarm_rate, tests_) / 2),
        least_limit_(student_t_quantile(1 - level_, a.batches() + b.batches() - 2)) {
    for (int c = 0; c < 3; ++c) image_mean_ += (sample_of(a, 0, c).mean + sample_of(b, 0, c).mean) / 6;
    margin_ = options.indifference * std::abs(image_mean_);
    for (std::size_t region = 0; region < region_count; ++region)
      if (a.pixels()[region] > 0)
        for (int c = 0; c < 3; ++c) compare(region, c);
  }

  std::size_t tests() const { return tests_; }
  double image_mean() const { return image_mean_; }
  const Comparison& worst_t() const { return worst_t_; }
  // Those nearest to a conviction: of all, and of those where the first is the darker.
  const Comparison& worst() const {
    return worst_of_first_lacks().conviction() > worst_[1].conviction() ? worst_of_first_lacks() : worst_[1];
  }
  const Comparison& worst_of_first_lacks() const { return worst_[0]; }
  // The least difference of the image's mean that would have convicted, relative to it.
  double resolution() const { return relative(margin_ + unresolved()); }
  // The same, as a radiance beyond the margin.
  double unresolved() const { return image_.limit + image_.allowance; }
  // Both may have missed as much light as they found, or more.
  bool may_lack_light() const { return unresolved() > 0 && margin_ + unresolved() >= std::abs(image_mean_); }
  // So many times the samples would find out; infinity: they have found nothing.
  double times_to_resolve() const {
    return image_mean_ != 0 ? image_.times_until(std::abs(image_mean_) - margin_) : std::numeric_limits<double>::infinity();
  }
  double relative(double radiance) const { return image_mean_ != 0 ? radiance / std::abs(image_mean_) : radiance; }

 private:
  void compare(std::size_t region, int channel) {
    const Sample x = sample_of(a_, region, channel), y = sample_of(b_, region, channel);
    const double variance = x.variance_of_mean + y.variance_of_mean, error = std::sqrt(variance);
    const BatchStatistics& darker = x.mean < y.mean ? a_ : b_;
    Comparison comparison{region, x.mean - y.mean, std::abs(x.mean - y.mean) - margin_};
    comparison.n = static_cast<double>(darker.samples());
    comparison.allowance = brightest_ * -std::log(level_) / (comparison.n * static_cast<double>(darker.pixels()[region]));
    // Fewer degrees of freedom only raise the limit: most comparisons cannot be the worst, and are spared the quantile.
    comparison.limit = least_limit_ * error;
    Comparison& worst = worst_[comparison.difference < 0 ? 0 : 1];
    if (region > 0 && comparison.t_ratio() <= worst_t_.t_ratio() && comparison.conviction() <= worst.conviction()) return;
    if (variance > 0) {
      // These are Welch and Satterthwaite's degrees of freedom.
      const double degrees = variance * variance /
                             (x.variance_of_mean * x.variance_of_mean / (a_.batches() - 1) +
                              y.variance_of_mean * y.variance_of_mean / (b_.batches() - 1));
      comparison.limit = error * student_t_quantile(1 - level_, degrees);
    }
    if (region == 0 && comparison.limit + comparison.allowance > unresolved()) image_ = comparison;
    if (comparison.t_ratio() > worst_t_.t_ratio()) worst_t_ = comparison;
    if (comparison.conviction() > worst.conviction()) worst = comparison;
  }

  const BatchStatistics &a_, &b_;
  double brightest_;
  std::size_t tests_;
  double level_;        // of each side of each test
  double least_limit_;  // of t
  double image_mean_ = 0, margin_ = 0;
  Comparison worst_t_, image_;
  std::array<Comparison, 2> worst_;  // where the first is the darker, and where it is not
};

std::string samples_text(double times) {
  return std::isfinite(times) ? fmt::format("about {:.0f} times the samples can tell", std::ceil(times))
                              : "no number of samples is known that can tell";
}

// Writes the verdict's part of the text.
std::string describe(Agreement::Verdict verdict, const Comparisons& comparisons) {
  const Comparison& t = comparisons.worst_t();
  const Comparison& worst = verdict == Agreement::Verdict::disagree ? comparisons.worst() : t;
  const std::string where = fmt::format("{} by {:+.3g} % of the image's mean", BatchStatistics::region_name(worst.region),
                                        100 * comparisons.relative(worst.difference));
  if (verdict == Agreement::Verdict::agree)
    return fmt::format("agree, worst t at {:.0f} % of its limit; the image's mean resolved to {:.2g} %", 100 * t.t_ratio(),
                       100 * comparisons.resolution());
  if (verdict == Agreement::Verdict::cannot_tell && t.t_ratio() <= 1)
    return fmt::format(
        "{} whether both lack light: the image's mean is {:.3g}, and bright paths not yet seen may add {:.3g}; {}", undecided,
        comparisons.image_mean(), comparisons.unresolved(), samples_text(comparisons.times_to_resolve()));
  if (verdict == Agreement::Verdict::cannot_tell)
    return fmt::format(
        "{} whether they differ in {}: t at {:.0f} % of its limit, but bright paths not yet seen in {} samples "
        "may add {:.3g} %; {}",
        undecided, where, 100 * t.t_ratio(), t.n, 100 * comparisons.relative(t.allowance), samples_text(t.times_the_samples()));
  return fmt::format("DISAGREE in {}, where {:.3g} % could be chance (t at {:.0f} % of its limit)", where,
                     100 * comparisons.relative(worst.limit + worst.allowance), 100 * worst.t_ratio());
}

}  // namespace

BatchStatistics::BatchStatistics(ivec2 resolution, std::uint64_t samples_per_batch)
    : samples_per_batch_(samples_per_batch),
      mean_(resolution),
      squares_(resolution),
      cubes_(resolution),
      pixels_(region_count, 0) {
  for_each_region_pixel(mean_, [&](std::size_t region, const dvec3&) { ++pixels_[region]; });
}

void BatchStatistics::add(const Image& batch) {
  CHECK(batch.size == mean_.size);
  const double before = batches_++, n = batches_;
  for (std::size_t i = 0; i < batch.pixels.size(); ++i) {
    const dvec3 deviation = batch.pixels[i] - mean_.pixels[i], step = deviation / n, square = deviation * step * before;
    cubes_.pixels[i] += square * step * (n - 2) - 3.0 * step * squares_.pixels[i];
    squares_.pixels[i] += square;
    mean_.pixels[i] += step;
  }
  std::vector<dvec3> means(region_count, dvec3(0));
  for_each_region_pixel(batch, [&](std::size_t region, const dvec3& pixel) { means[region] += pixel; });
  for (std::size_t i = 0; i < means.size(); ++i)
    if (pixels_[i] > 0) means[i] /= static_cast<double>(pixels_[i]);  // an image of few pixels leaves blocks empty
  regions_.push_back(std::move(means));
}

template <class Scale>
double BatchStatistics::variance_over(const Scale& scale) const {
  CHECK_GT(batches_, 1);
  const double n = batches_;
  double sum = 0;
  for (std::size_t i = 0; i < squares_.pixels.size(); ++i) {
    const dvec3 scaled = squares_.pixels[i] / scale(i);
    sum += (scaled.x + scaled.y + scaled.z) / 3;
  }
  return sum / (n * (n - 1) * static_cast<double>(mean_.pixels.size()));
}

double BatchStatistics::mean_variance() const {
  return variance_over([](std::size_t) { return 1.0; });
}

double BatchStatistics::relative_variance(const Image& r) const {
  return variance_over([&](std::size_t i) { return r.pixels[i] * r.pixels[i] + relmse_epsilon; });
}

double BatchStatistics::rare_value() const {
  CHECK_GT(batches_, 2);
  const double n = batches_;
  dvec3 squares(0), cubes(0), variance(0);  // of the sum of cubes, of noise that is normal: 6 n sigma^6 a pixel
  for (std::size_t i = 0; i < squares_.pixels.size(); ++i) {
    const dvec3& s = squares_.pixels[i];
    squares += s;
    cubes += cubes_.pixels[i];
    variance += 6.0 * s * s * s / (n * n);
  }
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    if (squares[c] > 0) largest = std::max(largest, (cubes[c] + 3 * std::sqrt(variance[c])) / squares[c]);
  // The third of the unbiased cumulants of a batch's mean falls with the square of the samples in it.
  return largest * n / (n - 2) * static_cast<double>(samples_per_batch_);
}

std::string BatchStatistics::region_name(std::size_t region) {
  if (region == 0) return "the image";
  const auto block = static_cast<int>(region) - 1;
  return fmt::format("block ({}, {}) of {} x {}", block % grid, block / grid, grid, grid);
}

Agreement compare_means(const BatchStatistics& a, const BatchStatistics& b, const AgreementOptions& options) {
  const Comparisons comparisons(a, b, options);
  using Verdict = Agreement::Verdict;
  Agreement result;
  result.verdict = comparisons.worst().conviction() > 1  ? Verdict::disagree
                   : comparisons.worst_t().t_ratio() > 1 ? Verdict::cannot_tell
                                                         : Verdict::agree;
  result.first_lacks = comparisons.worst_of_first_lacks().conviction() > 1;
  if (result.verdict == Verdict::cannot_tell) result.times_the_samples = comparisons.worst_t().times_the_samples();
  if (result.verdict == Verdict::agree && comparisons.may_lack_light()) {
    result.verdict = Verdict::cannot_tell;
    result.times_the_samples = comparisons.times_to_resolve();
    result.may_lack = comparisons.unresolved();
  }
  result.text =
      fmt::format("{} t-tests of means (3 channels, image and {} x {} blocks, {} and {} batches, false-alarm rate {:g}): {}",
                  comparisons.tests(), grid, grid, a.batches(), b.batches(), options.false_alarm_rate,
                  describe(result.verdict, comparisons));
  return result;
}

}  // namespace etendue
