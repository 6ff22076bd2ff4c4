#include "framework/io/image/png.h"

#include "framework/io/image/image_file.h"

#include <cmath>
#include <vector>

namespace etendue {

std::uint8_t linear_to_srgb_byte(double linear) {
  const double x = std::isnan(linear) ? 0 : std::clamp(linear, 0.0, 1.0);
  const double curved = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * curved));
}

FileStamp write_png(const std::string& path, const Image& image) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(3 * image.pixels.size());
  for (const dvec3& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) pixels.push_back(linear_to_srgb_byte(pixel[c]));
  const std::vector<std::uint8_t> bytes = encode_png(pixels.data(), image.size);
  return write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace etendue
