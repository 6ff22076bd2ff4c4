#include "framework/io/image/pfm.h"

#include "framework/core/memory.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace etendue {

namespace {

float float_at(std::string_view bytes, std::size_t at, bool big_endian) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return std::bit_cast<float>(big_endian == (std::endian::native == std::endian::big) ? word : __builtin_bswap32(word));
}

}  // namespace

bool is_pfm(std::string_view bytes) { return bytes.starts_with("PF\n") || bytes.starts_with("Pf\n"); }

RgbImage decode_pfm(std::string_view bytes) {
  const std::size_t channels = bytes[1] == 'F' ? 3 : 1;
  WordReader words(bytes);
  words.word();
  double header[3];  // width, height, scale
  for (double& number : header) {
    const auto read = parse_number(words.word_on_any_line());
    if (!read) throw Error("a PFM header must hold width, height and scale");
    number = *read;
  }
  const auto whole = [](double n) { return n >= 1 && n <= 65536 && n == std::floor(n); };
  if (!whole(header[0]) || !whole(header[1]) || header[2] == 0)
    throw Error(fmt::format("the header states {} x {} and the scale {}", header[0], header[1], header[2]));
  RgbImage image{.size = ivec2(static_cast<int>(header[0]), static_cast<int>(header[1])), .texels = {}};
  const std::size_t begin = words.offset() + 1, pixels = static_cast<std::size_t>(image.size.x) * image.size.y;
  const std::size_t needed = pixels * channels * sizeof(float);
  if (bytes.size() < begin || bytes.size() - begin < needed)
    throw Error(fmt::format("the header announces {} x {} pixels, in a file of {} bytes", header[0], header[1], bytes.size()));
  require_memory(static_cast<double>(pixels) * sizeof(Rgb), {}, "the image", "fewer pixels");
  image.texels.resize(pixels);
  const auto scale = static_cast<float>(std::abs(header[2]));  // its sign tells the order of bytes
  for (int y = 0; y < image.size.y; ++y)
    for (int x = 0; x < image.size.x; ++x) {
      const auto width = static_cast<std::size_t>(image.size.x);
      const std::size_t at = begin + (static_cast<std::size_t>(image.size.y - 1 - y) * width + x) * channels * sizeof(float);
      Rgb& texel = image.texels[y * width + x];
      for (std::size_t c = 0; c < 3; ++c)
        texel[static_cast<int>(c)] = scale * float_at(bytes, at + (channels == 3 ? c * sizeof(float) : 0), header[2] > 0);
    }
  return image;
}

}  // namespace etendue
