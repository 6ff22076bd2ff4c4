#include "experiments/kinds/stress/stress_figures.h"

#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace etendue {

namespace {

double brightness(const dvec3& pixel) { return (pixel.x + pixel.y + pixel.z) / 3; }

template <class Transform>
double ratio_quantile(const Image& image, const Image& reference, double least, double p, const Transform& transform) {
  CHECK(image.size == reference.size);
  double largest = 0;
  for (const dvec3& pixel : reference.pixels) largest = std::max(largest, brightness(pixel));
  std::vector<double> ratios;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i)
    if (const double t = brightness(reference.pixels[i]); t > 0 && t >= least * largest)
      ratios.push_back(transform(brightness(image.pixels[i]) / t));
  CHECK(!ratios.empty());
  return quantile(ratios, p);
}

double ratio_at(const Image& image, const Image& reference, double p, double least = 1e-3) {
  return ratio_quantile(image, reference, least, p, [](double ratio) { return ratio; });
}

double darkest(const Image& image, const Image& reference) { return ratio_at(image, reference, 0.01, 0.9); }
double middle(const Image& image, const Image& reference) { return ratio_at(image, reference, 0.5); }
double brightest(const Image& image, const Image& reference) { return ratio_at(image, reference, 0.99); }
double blotches(const Image& image, const Image& reference) {
  return ratio_quantile(image, reference, 1e-3, 0.95, [](double ratio) { return std::abs(ratio - 1); });
}

}  // namespace

std::span<const StressFigure> stress_figures() {
  static const StressFigure all[] = {{"bias", "relative error of the image's mean", bias},
                                     {"relmse", "relmse", relmse},
                                     {"darkest", "pixel over the reference where it is lit evenly, 1st percentile", darkest},
                                     {"middle", "pixel over the reference, median", middle},
                                     {"brightest", "pixel over the reference, 99th percentile", brightest},
                                     {"blotches", "relative error of pixels, 95th percentile", blotches}};
  return all;
}

const StressFigure& find_stress_figure(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const StressFigure& figure : stress_figures()) {
    if (figure.name == name) return figure;
    names.push_back(figure.name);
  }
  throw Error(where, unknown_name("figure", name, names));
}

}  // namespace etendue
