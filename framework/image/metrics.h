// The one definition of each error metric. x: image, r: reference, both linear RGB; means run over all pixels and the three
// channels; no pixel is skipped.
//
//   mse              mean (x - r)^2
//   relmse           mean (x - r)^2 / (r^2 + epsilon), epsilon = 0.01
//   trimmed_relmse   the same without the largest 0.1 % of pixels (a pixel's value: mean over its channels)
//   smape            mean |x - r| / (|x| + |r|), 0 where both are 0
//   bias             mean (x - r) / mean r: signed and relative; with one image it holds noise / sqrt(pixels)
//   flip             mean of HDR-FLIP over pixels (flip.h), which looks at a pixel's surroundings
#pragma once

#include "framework/image/film.h"

#include <string>
#include <string_view>
#include <vector>

namespace etendue {

inline constexpr double relmse_epsilon = 0.01;
inline constexpr double trimmed_fraction = 0.001;

double mse(const Image& image, const Image& reference);
double relmse(const Image& image, const Image& reference);
double trimmed_relmse(const Image& image, const Image& reference);
double smape(const Image& image, const Image& reference);
double bias(const Image& image, const Image& reference);
double flip(const Image& image, const Image& reference);  // throws Error where a pixel is not finite

struct Metric {
  std::string_view name, formula;
  double (*compute)(const Image&, const Image&);  // CHECKs equal sizes
  // Gives the error of each pixel, whose mean is the metric, where the metric looks at pixels' surroundings; else it is null.
  // It throws Error where a pixel is not finite, and costs so much that it is measured only where somebody asks for it.
  std::vector<double> (*errors)(const Image&, const Image&) = nullptr;

  bool on_request() const { return errors != nullptr; }
};
const std::vector<Metric>& metrics();
const Metric* find_metric(std::string_view name);

double mean_of(const std::vector<double>& values);  // at least one

// Per pixel, mean over channels of (x - r)^2 / (r^2 + epsilon): the error map of the report.
std::vector<double> relative_squared_errors(const Image& image, const Image& reference);

}  // namespace etendue
