#include "framework/image/flip.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace etendue {

namespace {

constexpr double pixels_per_degree = 3840 * std::numbers::pi / 180;

// --- filters ---

using Plane = std::vector<float>;
using Kernel = std::vector<float>;  // an odd number of weights about a pixel

template <class Weight>
Kernel kernel(int radius, const Weight& weight) {
  Kernel weights;
  for (int i = -radius; i <= radius; ++i) weights.push_back(static_cast<float>(weight(i)));
  return weights;
}

// Scales a kernel's positive weights to sum to 1, and its negative ones, where it has any, to -1.
Kernel normalised(Kernel weights) {
  double positive = 0, negative = 0;
  for (const float w : weights) (w > 0 ? positive : negative) += std::abs(static_cast<double>(w));
  for (float& w : weights) w = static_cast<float>(w / (w > 0 ? positive : negative > 0 ? negative : 1));
  return weights;
}

// A contrast sensitivity in the frequency domain is exp(-b f^2); in space, over degrees x, it is
// a sqrt(pi / b) exp(-pi^2 x^2 / b) ([Andersson2020]).
struct Sensitivity {
  double a, b;
  double at(double degrees) const {
    constexpr double pi = std::numbers::pi;
    return a * std::sqrt(pi / b) * std::exp(-pi * pi * degrees * degrees / b);
  }
};
constexpr Sensitivity achromatic{1, 0.0047}, red_green{1, 0.0053}, blue_yellow_wide{34.1, 0.04},
    blue_yellow_narrow{13.5, 0.025};

struct Filters {
  int reach = 0;  // rows and columns that the largest kernel takes in on either side
  Kernel y, cx;
  std::array<Kernel, 2> cz;  // a sum of two
  std::array<float, 2> cz_share{};
  Kernel smooth, edge, point;

  Filters() {
    const double widest = std::sqrt(blue_yellow_wide.b / 2) / std::numbers::pi;  // standard deviation in degrees
    const int radius = static_cast<int>(std::ceil(3 * widest * pixels_per_degree));
    const auto of = [&](const Sensitivity& s) { return kernel(radius, [&](int i) { return s.at(i / pixels_per_degree); }); };
    y = normalised(of(achromatic));
    cx = normalised(of(red_green));
    double whole = 0;
    for (int i = 0; i < 2; ++i) {
      const Sensitivity& s = i == 0 ? blue_yellow_wide : blue_yellow_narrow;
      const Kernel weights = of(s);
      double sum = 0;
      for (const float w : weights) sum += w;
      // The plane's weight is a sqrt(pi / b) once, not once for each direction.
      cz_share[i] = static_cast<float>(sum * sum / s.at(0));
      whole += cz_share[i];
      cz[i] = normalised(weights);
    }
    for (float& share : cz_share) share = static_cast<float>(share / whole);
    // The features that an eye detects have a width of 0.082 degrees from peak to trough.
    const double deviation = 0.5 * 0.082 * pixels_per_degree, variance = deviation * deviation;
    const int feature_radius = static_cast<int>(std::ceil(3 * deviation));
    const auto gaussian = [&](int i) { return std::exp(-i * i / (2 * variance)); };
    smooth = normalised(kernel(feature_radius, gaussian));
    edge = normalised(kernel(feature_radius, [&](int i) { return -i * gaussian(i); }));
    point = normalised(kernel(feature_radius, [&](int i) { return (i * i / variance - 1) * gaussian(i); }));
    reach = std::max(radius, feature_radius);
  }
};

const Filters& filters() {
  static const Filters all;
  return all;
}

// Rows of planes, with `reach` further rows above and below them.
struct Band {
  int width = 0, rows = 0, reach = 0;  // `rows`: without the further ones

  // Beyond the image's sides its last columns go on.
  Plane along_x(const Plane& in, const Kernel& weights) const {
    const int radius = static_cast<int>(weights.size()) / 2;
    Plane out(in.size(), 0.0f), row(static_cast<std::size_t>(width) + 2 * radius);
    for (std::size_t at = 0; at < in.size(); at += width) {
      std::fill_n(row.begin(), radius, in[at]);
      std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(at), width, row.begin() + radius);
      std::fill_n(row.begin() + radius + width, radius, in[at + width - 1]);
      for (std::size_t k = 0; k < weights.size(); ++k)
        for (int x = 0; x < width; ++x) out[at + x] += weights[k] * row[x + k];
    }
    return out;
  }
  Plane along_y(const Plane& in, const Kernel& weights) const {
    const int skipped = reach - static_cast<int>(weights.size()) / 2;
    Plane out(static_cast<std::size_t>(rows) * width, 0.0f);
    for (int y = 0; y < rows; ++y)
      for (std::size_t k = 0; k < weights.size(); ++k) {
        const float* from = in.data() + (static_cast<std::size_t>(y) + skipped + k) * width;
        float* to = out.data() + static_cast<std::size_t>(y) * width;
        for (int x = 0; x < width; ++x) to[x] += weights[k] * from[x];
      }
    return out;
  }
  Plane filtered(const Plane& in, const Kernel& weights) const { return along_y(along_x(in, weights), weights); }
};

// --- colours ---

// Linear RGB to XYZ over that of white: rows of the sRGB matrix for D65, each divided by its sum.
dvec3 to_relative_xyz(const dvec3& rgb) {
  constexpr dvec3 x{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794};
  constexpr dvec3 y{2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897};
  constexpr dvec3 z{1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382};
  const auto row = [&](const dvec3& weights) { return glm::dot(weights, rgb) / (weights.x + weights.y + weights.z); };
  return {row(x), row(y), row(z)};
}

const glm::dmat3& from_relative_xyz() {
  static const glm::dmat3 inverse = [] {
    const dvec3 r = to_relative_xyz({1, 0, 0}), g = to_relative_xyz({0, 1, 0}), b = to_relative_xyz({0, 0, 1});
    return glm::inverse(glm::dmat3(r, g, b));
  }();
  return inverse;
}

// L*, and a* and b* scaled by L* / 100: colours fade with brightness, as Hunt found.
dvec3 to_hunt_lab(const dvec3& relative_xyz) {
  constexpr double delta = 6.0 / 29;
  const auto f = [](double t) { return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29; };
  const dvec3 v(f(relative_xyz.x), f(relative_xyz.y), f(relative_xyz.z));
  const double lightness = 116 * v.y - 16;
  return {lightness, 0.01 * lightness * 500 * (v.x - v.y), 0.01 * lightness * 200 * (v.y - v.z)};
}

double hyab(const dvec3& a, const dvec3& b) { return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z); }

constexpr double colour_exponent = 0.7;
double largest_colour_difference() {
  static const double most =
      std::pow(hyab(to_hunt_lab(to_relative_xyz({0, 1, 0})), to_hunt_lab(to_relative_xyz({0, 0, 1}))), colour_exponent);
  return most;
}

// Small differences take most of the range: up to 0.4 of the largest it is [0, 0.95].
double colour_error(const dvec3& a, const dvec3& b) {
  const double most = largest_colour_difference(), knee = 0.4 * most, difference = std::pow(hyab(a, b), colour_exponent);
  return difference < knee ? 0.95 * difference / knee : 0.95 + 0.05 * (difference - knee) / (most - knee);
}

double feature_error(double edge_difference, double point_difference) {
  return std::sqrt(std::max(std::abs(edge_difference), std::abs(point_difference)) / std::numbers::sqrt2);
}

// --- what an observer sees ---

struct Seen {                 // of the pixels of a band
  std::vector<dvec3> colour;  // Hunt-adjusted L*a*b*
  Plane edge, point;
};

std::vector<dvec3> seen_colours(const Band& band, const std::array<Plane, 3>& ycc) {
  const Filters& f = filters();
  const Plane y = band.filtered(ycc[0], f.y), cx = band.filtered(ycc[1], f.cx), wide = band.filtered(ycc[2], f.cz[0]),
              narrow = band.filtered(ycc[2], f.cz[1]);
  std::vector<dvec3> colours(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double cz = static_cast<double>(f.cz_share[0]) * wide[i] + static_cast<double>(f.cz_share[1]) * narrow[i];
    const dvec3 rgb = from_relative_xyz() * dvec3(y[i] + cx[i], y[i], y[i] - cz);
    colours[i] = to_hunt_lab(to_relative_xyz(glm::clamp(rgb, 0.0, 1.0)));
  }
  return colours;
}

Plane lengths(const Plane& x, const Plane& y) {
  Plane result(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) result[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
  return result;
}

// `show`: from linear RGB to what a screen shows of it, linear within [0, 1]. YCxCz is held as XYZ over white has it: Y, X - Y
// and Y - Z, which filters leave related as scaled and offset ones are.
template <class Show>
Seen see(const Band& band, const Image& image, int first_row, const Show& show) {
  std::array<Plane, 3> ycc;
  for (int y = first_row - band.reach; y < first_row + band.rows + band.reach; ++y)
    for (int x = 0; x < band.width; ++x) {
      const dvec3 xyz = to_relative_xyz(show(image.at(x, std::clamp(y, 0, image.size.y - 1))));
      ycc[0].push_back(static_cast<float>(xyz.y));
      ycc[1].push_back(static_cast<float>(xyz.x - xyz.y));
      ycc[2].push_back(static_cast<float>(xyz.y - xyz.z));
    }
  const Filters& f = filters();
  const Plane smooth = band.along_x(ycc[0], f.smooth);
  Seen seen;
  seen.colour = seen_colours(band, ycc);
  seen.edge = lengths(band.along_y(band.along_x(ycc[0], f.edge), f.smooth), band.along_y(smooth, f.edge));
  seen.point = lengths(band.along_y(band.along_x(ycc[0], f.point), f.smooth), band.along_y(smooth, f.point));
  return seen;
}

void require_finite(const Image& image, const char* which) {
  std::size_t count = 0, first = 0;
  for (std::size_t i = image.pixels.size(); i-- > 0;)
    if (const dvec3& p = image.pixels[i]; !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
      ++count;
      first = i;
    }
  const auto width = static_cast<std::size_t>(image.size.x);
  if (count > 0)
    throw Error(fmt::format("FLIP: {} of {} pixels of {} are not finite, the first at ({}, {}); expected finite ones", count,
                            image.pixels.size(), which, first % width, first / width));
}

// The largest LDR-FLIP of each pixel over all of `shows`, each of which takes a pixel's radiance to what a screen shows of it.
template <class Shows>
std::vector<double> largest_errors(const Image& image, const Image& reference, const Shows& shows) {
  CHECK(image.size == reference.size);
  require_finite(image, "the image");
  require_finite(reference, "the reference");
  constexpr int band_rows = 64;
  std::vector<double> errors(image.pixels.size(), 0);
  const int bands = (image.size.y + band_rows - 1) / band_rows;
  parallel_for(static_cast<std::size_t>(bands), 1, [&](std::size_t b) {
    const int first_row = static_cast<int>(b) * band_rows;
    const Band band{image.size.x, std::min(band_rows, image.size.y - first_row), filters().reach};
    double* error = errors.data() + static_cast<std::size_t>(first_row) * image.size.x;
    for (const auto& show : shows) {
      const Seen x = see(band, image, first_row, show), r = see(band, reference, first_row, show);
      for (std::size_t i = 0; i < x.colour.size(); ++i) {
        const double feature = feature_error(x.edge[i] - r.edge[i], x.point[i] - r.point[i]);
        error[i] = std::max(error[i], std::pow(colour_error(x.colour[i], r.colour[i]), 1 - feature));
      }
    }
  });
  return errors;
}

// --- exposures ---

// The tone map (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5) of x = 0.6 v, in terms of v.
constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43, k4 = 0.6 * 0.59, k5 = 0.14;

// The value that the tone map takes to t.
double tone_map_inverse(double t) {
  const double a = k0 - t * k3, b = k1 - t * k4, c = -t * k5;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

// The middle one, or the mean of the two in the middle, of those from `first` on.
double median_from(const std::vector<double>& sorted, std::size_t first) {
  const std::size_t count = sorted.size() - first;
  return 0.5 * (sorted[first + (count - 1) / 2] + sorted[first + count / 2]);
}

struct Exposed {
  double scale;
  dvec3 operator()(const dvec3& v) const {
    return {flip_tone_map(scale * v.x), flip_tone_map(scale * v.y), flip_tone_map(scale * v.z)};
  }
};

struct Clamped {
  dvec3 operator()(const dvec3& v) const { return glm::clamp(v, 0.0, 1.0); }
};

}  // namespace

double flip_tone_map(double value) {
  const double v = std::clamp(value, 0.0, 1e6);  // from there on it is white
  return std::min(1.0, v * (k0 * v + k1) / (v * (k3 * v + k4) + k5));
}

std::vector<double> flip_exposures(const Image& reference) {
  constexpr double target = 0.85, most_exposures = 64;  // [Andersson2021] has the first
  std::vector<double> luminances;
  luminances.reserve(reference.pixels.size());
  for (const dvec3& p : reference.pixels) luminances.push_back(glm::dot(glm::max(p, 0.0), dvec3(0.2126, 0.7152, 0.0722)));
  std::sort(luminances.begin(), luminances.end());
  if (luminances.empty() || luminances.back() == 0) return {0};
  const auto above = std::upper_bound(luminances.begin(), luminances.end(), 0.0) - luminances.begin();
  const double middle = median_from(luminances, 0);
  const double median = middle > 0 ? middle : median_from(luminances, static_cast<std::size_t>(above));
  const double start = std::log2(tone_map_inverse(target)) - std::log2(luminances.back());
  const double span = std::log2(luminances.back()) - std::log2(median);
  if (span == 0) return {start};
  const int count = static_cast<int>(std::clamp(std::ceil(span), 2.0, most_exposures));
  std::vector<double> exposures;
  for (int i = 0; i < count; ++i) exposures.push_back(start + i * span / (count - 1));
  return exposures;
}

std::vector<double> flip_errors(const Image& image, const Image& reference) {
  require_finite(reference, "the reference");
  std::vector<Exposed> shows;
  for (const double exposure : flip_exposures(reference)) shows.push_back({std::exp2(exposure)});
  return largest_errors(image, reference, shows);
}

std::vector<double> ldr_flip_errors(const Image& image, const Image& reference) {
  return largest_errors(image, reference, std::array{Clamped{}});
}

}  // namespace etendue
