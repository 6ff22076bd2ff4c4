#include "experiments/report/page/half_image.h"

#include "experiments/report/report_text.h"
#include "framework/core/check.h"

#include <Imath/half.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>

namespace etendue {
namespace {

half to_half(double value, double unit) {
  return half(static_cast<float>(std::clamp(value / unit, -static_cast<double>(HALF_MAX), static_cast<double>(HALF_MAX))));
}

// `value`(pixel, channel) of each pixel and of so many channels.
template <class Value>
std::string encode_planes(ivec2 size, int channels, double unit, const Value& value) {
  const std::size_t pixels = static_cast<std::size_t>(size.x) * size.y, count = static_cast<std::size_t>(channels) * pixels;
  std::vector<std::uint8_t> bytes(2 * count);
  for (int channel = 0; channel < channels; ++channel) {
    std::uint16_t before = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (i % static_cast<std::size_t>(size.x) == 0) before = 0;
      const std::uint16_t bits = to_half(value(i, channel), unit).bits();
      const auto difference = static_cast<std::uint16_t>(bits - before);
      const std::size_t at = static_cast<std::size_t>(channel) * pixels + i;
      bytes[at] = static_cast<std::uint8_t>(difference >> 8);
      bytes[count + at] = static_cast<std::uint8_t>(difference & 0xff);
      before = bits;
    }
  }
  uLongf length = compressBound(bytes.size());
  std::vector<std::uint8_t> packed(length);
  CHECK_EQ(compress2(packed.data(), &length, bytes.data(), bytes.size(), 6), Z_OK);
  packed.resize(length);
  return base64(packed);
}

}  // namespace

double rounded_to_half(double value, double unit) {
  return static_cast<double>(static_cast<float>(to_half(value, unit))) * unit;
}

std::string encode_halves(const std::vector<dvec3>& pixels, ivec2 size, double unit) {
  CHECK_EQ(pixels.size(), static_cast<std::size_t>(size.x) * size.y);
  return encode_planes(size, 3, unit, [&](std::size_t pixel, int channel) { return pixels[pixel][channel]; });
}

std::string encode_halves(const std::vector<double>& values, ivec2 size) {
  CHECK_EQ(values.size(), static_cast<std::size_t>(size.x) * size.y);
  return encode_planes(size, 1, 1, [&](std::size_t pixel, int) { return values[pixel]; });
}

}  // namespace etendue
