// Image files as textures and environments read them.
#pragma once

#include "framework/core/error.h"
#include "framework/core/vec.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace etendue {

struct Image;  // framework/image/film.h

// How the integers of an image file encode light. Files of floats (HDR, PFM, EXR) are always linear. Of `alpha` all three
// components are the alpha channel of PNG, TGA and EXR, and 1 for what has none or is of another format.
enum class Encoding : std::uint8_t { srgb, linear, alpha };

// Linear RGB, row 0 at the top.
struct RgbImage {
  static constexpr std::size_t most_listed = 10;

  ivec2 size{0};
  std::vector<Rgb> texels;
  // Texels that a file of floats holds as NaN or infinity are 0 here: their number, and column and row of the first ten.
  std::size_t not_finite = 0;
  std::vector<ivec2> first_not_finite = {};
  bool had_own_primaries = false;  // an EXR's, which were converted
};

// PNG, JPEG, TGA, BMP (8 or 16 bits), HDR (RGBE), PFM and EXR, told apart by their content; grey becomes RGB.
// Throws Error; `name` names the image in messages.
RgbImage decode_image(const std::string& bytes, const std::string& name, Encoding encoding = Encoding::srgb);
RgbImage read_image(const std::string& path, Encoding encoding = Encoding::srgb);

// Repeats each texel of an image that is not to be interpolated between texels, so that interpolation acts on 1/16 of one, or
// as little as 2^20 texels in all allow. Returns how often: 1 where the image is too large to be repeated.
// Throws Error at `where` when the memory that is free does not hold them.
int repeat_texels(RgbImage& image, const Location& where);

// Any of them as an image to measure: floats as they are, integers taken for sRGB. `warnings` grows by a sentence where pixels
// are not finite: they stay so in EXR (a name that ends in .exr), and count as 0 in other files. `attributes`: of EXR.
Image read_as_image(const std::string& path, std::vector<std::string>& warnings,
                    std::map<std::string, std::string>* attributes = nullptr);

// `rgb`: 3 bytes per pixel, rows from the top. The bytes of a PNG file.
std::vector<std::uint8_t> encode_png(const std::uint8_t* rgb, ivec2 size);

}  // namespace etendue
