// Images as papers show them: tone-mapped, resampled, framed and named, in 8-bit sRGB.
#pragma once

#include "framework/image/film.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

using Colour = std::array<std::uint8_t, 3>;

struct Window {
  ivec2 begin{0}, size{0};  // pixels
};

// How an image differs from its reference at a pixel, by luminance: red where it is brighter, blue where it is darker, full at
// a factor of two; white where they are alike, grey where a value is not finite. Below a thousandth of white all
// counts as dark.
Colour difference_colour(const dvec3& image, const dvec3& reference, double white);

// White lies a quarter above the 98th percentile of the brightest channel: lamps in view do not darken the room, and an evenly
// lit scene is light grey, not white.
double white_of(const Image& image);

// A picture that is drawn on; white at first.
class Canvas {
 public:
  explicit Canvas(ivec2 size) : size_(size), bytes_(3 * static_cast<std::size_t>(size.x) * size.y, 255) {}

  ivec2 size() const { return size_; }
  void set(ivec2 pixel, const Colour& colour);  // outside nothing is drawn
  void draw(const Canvas& picture, ivec2 at);
  void frame(const Window& window, const Colour& colour, int width);  // inside the window
  // ASCII (others become '?') in letters `scale` times as large as their 8 pixels, black; returns the width it takes.
  int text(ivec2 at, std::string_view text, int scale);
  std::string png() const;

 private:
  ivec2 size_;
  std::vector<std::uint8_t> bytes_;
};
int text_pixels(std::string_view text, int scale);

// A window of an image, tone-mapped, in a picture of any size: pixels are averaged where it is smaller, and repeated where it
// is larger.
Canvas picture_of(const Image& image, const Window& window, ivec2 size, double exposure);
// The differences there. Of both images the pixels are averaged before they are compared.
Canvas difference_of(const Image& image, const Image& reference, const Window& window, ivec2 size);

}  // namespace etendue
