#include "experiments/command/png.h"

#include "framework/core/error.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace etendue {

namespace {

// IEC 61966-2-1.
unsigned char to_srgb(double linear) {
  const double x = std::isnan(linear) ? 0 : std::clamp(linear, 0.0, 1.0);
  const double curved = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<unsigned char>(std::lround(255 * curved));
}

}  // namespace

void write_png(const std::string& path, const Image& image) {
  std::vector<unsigned char> pixels;
  pixels.reserve(3 * image.pixels.size());
  for (const dvec3& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) pixels.push_back(to_srgb(pixel[c]));
  std::string bytes;
  const auto append = [](void* out, void* data, int size) {
    static_cast<std::string*>(out)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
  };
  const bool encoded = stbi_write_png_to_func(append, &bytes, image.size.x, image.size.y, 3, pixels.data(), 3 * image.size.x);
  const std::string partial = path + ".part";
  std::ofstream file(partial, std::ios::binary);
  file << bytes;
  file.close();
  if (!encoded || !file || std::rename(partial.c_str(), path.c_str()) != 0) {
    std::remove(partial.c_str());
    throw Error(Location{path}, "cannot write the image; expected a writable path");
  }
}

}  // namespace etendue
