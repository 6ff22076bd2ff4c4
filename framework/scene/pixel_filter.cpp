#include "framework/scene/pixel_filter.h"

#include "framework/core/elementary.h"
#include "framework/core/error.h"
#include "framework/core/rng.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace etendue {

namespace {

constexpr int cells = 4096;  // of the tables: a thousandth of a pixel for a radius of two

double gaussian(double x, double sigma) { return math::exp(-x * x / (2 * sigma * sigma)); }

// [MitchellNetravali1988] eq. 8, for x within 2.
double mitchell(double x, double b, double c) {
  x = std::abs(x);
  if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
}

double sinc(double x) {
  const double y = std::numbers::pi * x;
  return std::abs(y) < 1e-5 ? 1 - y * y / 6 : math::sin(y) / y;
}

}  // namespace

double FilterShape::at(double x, int axis) const {
  const double r = radius[axis];
  if (!(std::abs(x) <= r)) return 0;
  switch (kind) {
    case FilterKind::box:
      return 1;
    case FilterKind::triangle:
      return r - std::abs(x);
    case FilterKind::gaussian:
      return std::max(0.0, gaussian(x, sigma) - gaussian(r, sigma));
    case FilterKind::mitchell:
      return mitchell(2 * x / r, b, c);
    case FilterKind::sinc:
      return sinc(x) * sinc(x / tau);
  }
  return 0;
}

std::string FilterShape::text() const {
  std::string text =
      fmt::format("{} of radius {:g} x {:g}", names_of(kind)[static_cast<std::size_t>(kind)], radius.x, radius.y);
  if (kind == FilterKind::gaussian) text += fmt::format(", sigma {:g}", sigma);
  if (kind == FilterKind::mitchell) text += fmt::format(", B {:g}, C {:g}", b, c);
  if (kind == FilterKind::sinc) text += fmt::format(", tau {:g}", tau);
  return text;
}

FilterShape named_filter(std::string_view name) {
  const FilterShape known[] = {{},
                               {.kind = FilterKind::triangle, .radius = vec2(2)},
                               {.kind = FilterKind::gaussian, .radius = vec2(1.5f)},
                               {.kind = FilterKind::mitchell, .radius = vec2(2)},
                               {.kind = FilterKind::sinc, .radius = vec2(4)}};
  std::vector<std::string> names;
  for (const FilterShape& shape : known) {
    names.emplace_back(names_of(shape.kind)[static_cast<std::size_t>(shape.kind)]);
    if (names.back() == name) return shape;
  }
  throw Error(Location{"--pixel-filter"}, unknown_name("pixel filter", std::string(name), names));
}

PixelFilter::PixelFilter(const FilterShape& shape) : shape_(shape) {
  for (int axis = 0; axis < 2; ++axis) {
    Axis& a = axes_[static_cast<std::size_t>(axis)];
    a.radius = shape.radius[axis];
    const double width = 2.0 * a.radius / cells;
    std::vector<double> values(cells);
    for (int i = 0; i < cells; ++i) values[static_cast<std::size_t>(i)] = shape.at(-a.radius + (i + 0.5) * width, axis);
    for (Part* part : {&a.positive, &a.negative}) {
      const double sign = part == &a.positive ? 1 : -1;
      for (const double value : values) part->mass += std::max(0.0, sign * value) * width;
      double sum = 0;
      for (const double value : values) {
        sum += std::max(0.0, sign * value) * width;
        part->sums.push_back(part->mass > 0 ? static_cast<float>(sum / part->mass) : 0);
      }
    }
  }
  const auto& [x, y] = axes_;
  const double negative = x.positive.mass * y.negative.mass + x.negative.mass * y.positive.mass;
  share_negative_ = negative / ((x.positive.mass + x.negative.mass) * (y.positive.mass + y.negative.mass));
}

// Every 1 / share_negative_-th sample of a pixel is negative; which one is the first differs from pixel to pixel. Of the first
// n samples less than half are, so that the sum of their weights is never 0; from a few on this delays none.
bool PixelFilter::is_negative(std::uint64_t pixel, std::uint32_t index) const {
  const double start = to_unit_float(high_bits(hash_keys(pixel, 0x66696c746572)));
  const auto count = [&](double n) {
    return std::min(std::floor(start + n * share_negative_), std::floor(std::max(0.0, n - 1) / 2));
  };
  return count(index + 1.0) > count(index);
}

float PixelFilter::sample(const Axis& axis, const Part& part, float u) {
  const auto cell = std::min(std::upper_bound(part.sums.begin(), part.sums.end(), u), part.sums.end() - 1);
  const float below = cell == part.sums.begin() ? 0 : *(cell - 1), mass = *cell - below;
  const float within = mass > 0 ? std::clamp((u - below) / mass, 0.0f, 1.0f) : 0.5f;
  const auto i = static_cast<float>(cell - part.sums.begin());
  return axis.radius * (2 * (i + within) / cells - 1);
}

vec2 PixelFilter::place(const vec2& u, std::uint64_t pixel, std::uint32_t index) const {
  const auto& [x, y] = axes_;
  if (!is_signed()) return 0.5f + vec2(sample(x, x.positive, u.x), sample(y, y.positive, u.y));
  // The first number chooses between two products of parts with the sample's sign, and is used again.
  const bool negative = is_negative(pixel, index);
  const double first = x.positive.mass * (negative ? y.negative : y.positive).mass;
  const double second = x.negative.mass * (negative ? y.positive : y.negative).mass;
  const auto share = static_cast<float>(first / (first + second));
  const bool in_first = u.x < share;
  const float v = std::min(in_first ? u.x / share : (u.x - share) / (1 - share), 1 - 0x1p-24f);
  return 0.5f +
         vec2(sample(x, in_first ? x.positive : x.negative, v), sample(y, in_first != negative ? y.positive : y.negative, u.y));
}

float PixelFilter::density(const vec2& offset) const {
  return static_cast<float>(shape_.at(offset.x, 0) * shape_.at(offset.y, 1) / (axes_[0].integral() * axes_[1].integral()));
}

std::shared_ptr<const PixelFilter> make_pixel_filter(const FilterShape& shape) {
  return shape.is_pixel() ? nullptr : std::make_shared<const PixelFilter>(shape);
}

}  // namespace etendue
