// Reconstruction filters: what share of the light about a pixel counts for it, as the product of one function along x and one
// along y of the distance from the pixel's centre, in pixels.
//
//   box       1
//   triangle  radius - |x|
//   gaussian  exp(-x^2 / (2 sigma^2)) less its value at the radius
//   mitchell  the cubics of [MitchellNetravali1988] with B and C, stretched from their radius of 2 to this one
//   sinc      sinc(x) sinc(x / tau), Lanczos' window [Duchon1979]
//
// Filters are sampled: a camera ray's place on the film is drawn from the filter, so that a pixel is the mean of its samples
// and pixels stay independent of each other [Ernst2006]. Where the filter is negative (mitchell, sinc) the place is drawn from
// its absolute value, and the sample counts with its sign; which samples are negative is spread evenly over a pixel's samples.
// Their weighted mean is then consistent, with a bias of the order of one over their number, and a constant stays a constant.
#pragma once

#include "framework/core/vec.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

enum class FilterKind : std::uint8_t { box, triangle, gaussian, mitchell, sinc };
constexpr auto names_of(FilterKind) { return std::array{"box", "triangle", "gaussian", "mitchell", "sinc"}; }

struct FilterShape {
  FilterKind kind = FilterKind::box;
  vec2 radius{0.5f};                 // pixels, 0.01 .. 32; beyond it the filter is 0
  float sigma = 0.5f;                // pixels, of gaussian
  float b = 1.0f / 3, c = 1.0f / 3;  // of mitchell
  float tau = 3;                     // of sinc, periods within the window

  // The value is not normalised; `axis` is 0 or 1.
  double at(double x, int axis) const;
  bool is_pixel() const { return kind == FilterKind::box && radius == vec2(0.5f); }
  std::string text() const;  // "gaussian of radius 1.5 x 1.5, sigma 0.5"
  bool operator==(const FilterShape&) const = default;
};

// The filter of that name as pbrt-v4 has it by default, with a box of one pixel. Throws Error with the nearest names.
FilterShape named_filter(std::string_view name);

class PixelFilter {
 public:
  explicit PixelFilter(const FilterShape& shape);

  const FilterShape& shape() const { return shape_; }
  bool is_signed() const { return share_negative_ > 0; }

  // The place of the sample `index` of a pixel, from the pixel's corner (so that a box gives `u` itself), in pixels. `pixel`:
  // its key. The density is that of the filter's part of the sample's sign.
  vec2 place(const vec2& u, std::uint64_t pixel, std::uint32_t index) const;
  // The weight of the sample: 1, or the sign of its part.
  float weight(std::uint64_t pixel, std::uint32_t index) const {
    return is_signed() && is_negative(pixel, index) ? -1.0f : 1.0f;
  }
  // The filter at an offset from a pixel's centre, over its integral: what light that falls there adds to the pixel.
  float density(const vec2& offset) const;

 private:
  // One sign of the filter along one axis: its integral over cells of equal width, summed up to each.
  struct Part {
    std::vector<float> sums;
    double mass = 0;
  };
  struct Axis {
    float radius;
    Part positive, negative;
    double integral() const { return positive.mass - negative.mass; }
  };

  bool is_negative(std::uint64_t pixel, std::uint32_t index) const;
  static float sample(const Axis& axis, const Part& part, float u);

  FilterShape shape_;
  std::array<Axis, 2> axes_;
  double share_negative_ = 0;  // of the absolute value's integral
};

// Null for a box of one pixel, which needs none.
std::shared_ptr<const PixelFilter> make_pixel_filter(const FilterShape& shape);

}  // namespace etendue
