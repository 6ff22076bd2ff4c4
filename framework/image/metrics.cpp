#include "framework/image/metrics.h"

#include "framework/core/check.h"
#include "framework/image/flip.h"

#include <numeric>

namespace etendue {

namespace {

// Neumaier's compensated sum, so that the order of magnitude of an image's pixels does not matter.
class Sum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    compensation_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  double value() const { return sum_ + compensation_; }

 private:
  double sum_ = 0, compensation_ = 0;
};

template <class Term>
double mean_over_channels(const Image& image, const Image& reference, const Term& term) {
  CHECK(image.size == reference.size);
  CHECK_GT(image.pixels.size(), 0u);
  Sum sum;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) sum.add(term(image.pixels[i][c], reference.pixels[i][c]));
  return sum.value() / (3.0 * static_cast<double>(image.pixels.size()));
}

double relative_square(double x, double r) { return (x - r) * (x - r) / (r * r + relmse_epsilon); }

}  // namespace

double mse(const Image& image, const Image& reference) {
  return mean_over_channels(image, reference, [](double x, double r) { return (x - r) * (x - r); });
}

double relmse(const Image& image, const Image& reference) { return mean_over_channels(image, reference, relative_square); }

double trimmed_relmse(const Image& image, const Image& reference) {
  std::vector<double> errors = relative_squared_errors(image, reference);
  const auto kept = errors.size() - static_cast<std::size_t>(trimmed_fraction * static_cast<double>(errors.size()));
  std::sort(errors.begin(), errors.end());
  Sum sum;
  for (std::size_t i = 0; i < kept; ++i) sum.add(errors[i]);
  return sum.value() / static_cast<double>(kept);
}

double smape(const Image& image, const Image& reference) {
  return mean_over_channels(image, reference, [](double x, double r) {
    const double size = std::abs(x) + std::abs(r);
    return size == 0 ? 0 : std::abs(x - r) / size;
  });
}

double bias(const Image& image, const Image& reference) {
  const double difference = mean_over_channels(image, reference, [](double x, double r) { return x - r; });
  const double level = mean_over_channels(image, reference, [](double, double r) { return r; });
  return level == 0 ? difference : difference / level;
}

double flip(const Image& image, const Image& reference) { return mean_of(flip_errors(image, reference)); }

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> all{
      {"mse", "mean (x - r)^2", mse},
      {"relmse", "mean (x - r)^2 / (r^2 + 0.01)", relmse},
      {"trimmed_relmse", "relmse without the worst 0.1 % of pixels", trimmed_relmse},
      {"smape", "mean |x - r| / (|x| + |r|)", smape},
      {"bias", "mean (x - r) / mean r, signed; absolute where the reference is black", bias},
      {"flip", "mean HDR-FLIP, from 0 to 1; an experiment measures it where its metrics list it", flip, flip_errors},
  };
  return all;
}

const Metric* find_metric(std::string_view name) {
  for (const Metric& metric : metrics())
    if (metric.name == name) return &metric;
  return nullptr;
}

double mean_of(const std::vector<double>& values) {
  CHECK_GT(values.size(), 0u);
  Sum sum;
  for (const double value : values) sum.add(value);
  return sum.value() / static_cast<double>(values.size());
}

std::vector<double> relative_squared_errors(const Image& image, const Image& reference) {
  CHECK(image.size == reference.size);
  std::vector<double> errors(image.pixels.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    for (int c = 0; c < 3; ++c) errors[i] += relative_square(image.pixels[i][c], reference.pixels[i][c]);
    errors[i] /= 3;
  }
  return errors;
}

}  // namespace etendue
