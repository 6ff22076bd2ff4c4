#include "experiments/kinds/stress/stress_figures.h"

#include "experiments/kinds/rows.h"
#include "experiments/kinds/stress/structure_hazard.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace etendue {

namespace {

double brightness(const dvec3& pixel) { return (pixel.x + pixel.y + pixel.z) / 3; }

// A quantile of pixels over the reference's, where that is at least a share of its largest value.
double ratio_quantile(
    const Image& image, const Image& reference, double p, double least = 1e-3,
    double (*transform)(double ratio) = [](double ratio) { return ratio; }) {
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

}  // namespace

std::vector<double> image_tails(const std::vector<Image>& images, const Image& reference) {
  constexpr double share = 0.05;
  if (images.size() < 2) return {};
  double largest = 0;
  for (const dvec3& pixel : reference.pixels) largest = std::max(largest, brightness(pixel));
  std::vector<double> tails;
  for (const Image& image : images) {
    std::vector<double> light, noise;
    for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
      const double truth = brightness(reference.pixels[i]), own = brightness(image.pixels[i]);
      if (!(truth > 0 && truth >= 1e-3 * largest)) continue;
      double expected = -own;
      for (const Image& other : images) expected += brightness(other.pixels[i]);
      expected /= static_cast<double>(images.size() - 1);
      const double ratio = 1 + (own - expected) / truth;
      light.push_back(own >= 1e-3 * truth ? 1 : 0);
      noise.push_back(std::isfinite(ratio) ? std::max(0.0, ratio) : 1e30);
    }
    const bool is_lit = !noise.empty() && tail_index(light, share) > 0;
    tails.push_back(is_lit ? tail_index(noise, share) : 0);
  }
  return tails;
}

std::span<const StressFigure> stress_figures() {
  static const StressFigure all[] = {
      {"bias", "relative error of the image's mean", bias},
      {"relmse", "relmse", relmse},
      {"darkest", "pixel over the reference where it is lit evenly, 1st percentile",
       [](const Image& image, const Image& reference) { return ratio_quantile(image, reference, 0.01, 0.9); }},
      {"middle", "pixel over the reference, median",
       [](const Image& image, const Image& reference) { return ratio_quantile(image, reference, 0.5); }},
      {"brightest", "pixel over the reference, 99th percentile",
       [](const Image& image, const Image& reference) { return ratio_quantile(image, reference, 0.99); }},
      {"blotches", "relative error of pixels, 95th percentile",
       [](const Image& image, const Image& reference) {
         return ratio_quantile(image, reference, 0.95, 1e-3, [](double ratio) { return std::abs(ratio - 1); });
       }},
      {"work", "nodes and primitives per ray, over those at the harmless end", nullptr,
       [](const StructureHazard& measured) { return measured.work_per_ray(); }},
      {"memory", "bytes per primitive, over those at the harmless end", nullptr,
       [](const StructureHazard& measured) { return measured.bytes_per_primitive; }}};
  return all;
}

const StressFigure& find_stress_figure(const std::string& name, const Location& where) {
  return find_by_name(stress_figures(), "figure", name, where);
}

}  // namespace etendue
