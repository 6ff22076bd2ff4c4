#include "framework/io/image/image_file.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "framework/core/huge_pages.h"
#include "framework/core/memory.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/gamma.h"
#include "framework/io/image/hdr.h"
#include "framework/io/image/pfm.h"
#include "framework/io/text.h"

// The one place where stb's functions are compiled.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_MAX_DIMENSIONS 65536
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>

namespace etendue {

namespace {

// IEC 61966-2-1.
float srgb_to_linear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : math::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

template <class Word>
struct Pixels {
  std::unique_ptr<Word, void (*)(void*)> words;
  Pixels(Word* w) : words(w, &stbi_image_free) {
    if (!w) throw Error(fmt::format("it is cut short, damaged, or of a kind that is not read ({})", stbi_failure_reason()));
  }
};

template <class Word>
void decode(const Word* words, Encoding encoding, std::vector<Rgb>& texels) {
  constexpr std::size_t levels = std::size_t{std::numeric_limits<Word>::max()} + 1;
  std::vector<float> table(levels);
  for (std::size_t i = 0; i < levels; ++i) {
    const float value = static_cast<float>(i) / static_cast<float>(levels - 1);
    table[i] = encoding == Encoding::srgb ? srgb_to_linear(value) : value;
  }
  for (std::size_t i = 0; i < texels.size(); ++i)
    texels[i] = {table[words[3 * i]], table[words[3 * i + 1]], table[words[3 * i + 2]]};
}

// Checks the size a header states against the file's length before anything is allocated: deflate packs at most 1 : 1032 (of
// pixels of one bit), a JPEG of one colour about as much, and runs of a TGA 128 pixels into two bytes.
void check_size(int width, int height, std::string_view bytes) {
  const std::int64_t pixels = std::int64_t{width} * height;
  const bool runs_only = !bytes.starts_with("\x89PNG") && !bytes.starts_with("\xff\xd8");
  if (pixels < 1 || pixels > (std::int64_t{1} << 27) ||
      pixels > static_cast<std::int64_t>(bytes.size()) * (runs_only ? 64 : 10000))
    throw Error(fmt::format("the header announces {} x {} pixels, in a file of {} bytes", width, height, bytes.size()));
  // A pixel takes three words of 16 bits at most, and the texel that they become.
  if (pixels > (1 << 22)) require_memory(static_cast<double>(pixels) * (sizeof(Rgb) + 6), {}, "the image", "fewer pixels");
}

// This stb writes past its tables when a JPEG states Huffman tables of more than 256 codes, so such files are refused first.
// The segments up to the image data are passed; after that, where no segment but a table's holds these bytes, every one is
// checked.
void check_huffman_tables(std::string_view bytes) {
  // No format begins so; stb would take it for padding before a JPEG's first marker.
  if (bytes.starts_with("\xff\xff")) throw Error("neither PNG, JPEG, TGA, BMP, HDR, PFM nor EXR, or damaged");
  if (!bytes.starts_with("\xff\xd8")) return;
  const auto byte = [&](std::size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u; };
  bool in_data = false;
  for (std::size_t i = 2; i + 1 < bytes.size();) {
    const unsigned marker = byte(i + 1);
    if (byte(i) != 0xff || marker == 0 || marker == 0xff || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd9)) {
      ++i;
      continue;
    }
    const std::size_t end = i + 2 + 256 * byte(i + 2) + byte(i + 3);
    if (marker == 0xc4) {
      for (std::size_t table = i + 4; table < end;) {
        std::size_t codes = 0;
        for (std::size_t length = 1; length <= 16; ++length) codes += byte(table + length);
        if (codes > 256) throw Error("a Huffman table of more than 256 codes");
        table += 17 + codes;
      }
    }
    in_data |= marker == 0xda;
    i = in_data ? i + 2 : std::max(end, i + 2);
  }
}

// Hands stb a file and knows whether it wanted more than there is: it would go on with zeros.
class StbReader {
 public:
  explicit StbReader(std::string_view bytes) : rest_(bytes) {}

  template <class Function, class... Arguments>
  auto operator()(Function* function, Arguments... arguments) {
    const stbi_io_callbacks callbacks{
        [](void* self, char* out, int size) {
          return static_cast<StbReader*>(self)->take(out, static_cast<std::size_t>(size));
        },
        [](void* self, int size) { static_cast<StbReader*>(self)->take(nullptr, static_cast<std::size_t>(std::max(size, 0))); },
        [](void* self) { return static_cast<int>(static_cast<StbReader*>(self)->rest_.empty()); }};
    return function(&callbacks, this, arguments...);
  }
  bool ended() const { return ended_; }

 private:
  int take(char* out, std::size_t size) {
    const std::size_t taken = std::min(size, rest_.size());
    // Its buffer is filled as far as there are bytes; whatever else it asks for it needs.
    ended_ |= taken == 0 || (taken < size && size != sizeof(stbi__context::buffer_start));
    if (out) std::copy_n(rest_.data(), taken, out);
    rest_.remove_prefix(taken);
    return static_cast<int>(taken);
  }

  std::string_view rest_;
  bool ended_ = false;
};

template <class Word>
void load(const std::string& bytes, Word* (*function)(const stbi_io_callbacks*, void*, int*, int*, int*, int),
          Encoding encoding, std::vector<Rgb>& texels) {
  StbReader reader(bytes);
  int x = 0, y = 0, channels = 0;
  const bool of_alpha = encoding == Encoding::alpha;
  const Pixels<Word> pixels = reader(function, &x, &y, &channels, of_alpha ? 4 : 3);
  if (reader.ended()) throw Error("the file is cut short");
  if (!of_alpha) return decode(pixels.words.get(), encoding, texels);
  for (std::size_t i = 0; i < texels.size(); ++i)
    texels[i] = Rgb(static_cast<float>(pixels.words.get()[4 * i + 3]) / std::numeric_limits<Word>::max());
}

RgbImage decode_stb(const std::string& bytes, Encoding encoding) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) throw Error("larger than 2 GiB");
  check_huffman_tables(bytes);
  RgbImage image;
  int channels = 0;
  if (!StbReader(bytes)(&stbi_info_from_callbacks, &image.size.x, &image.size.y, &channels))
    throw Error("neither PNG, JPEG, TGA, BMP, HDR, PFM nor EXR, or damaged");
  check_size(image.size.x, image.size.y, bytes);
  resize_on_huge_pages(image.texels, static_cast<std::size_t>(image.size.x) * image.size.y);
  if (StbReader(bytes)(&stbi_is_16_bit_from_callbacks))
    load<stbi_us>(bytes, &stbi_load_16_from_callbacks, encoding, image.texels);
  else
    load<stbi_uc>(bytes, &stbi_load_from_callbacks, encoding, image.texels);
  return image;
}

RgbImage decode_exr(const std::string& bytes, const std::string& name, bool alpha) {
  RgbImage image;
  const Image pixels = parse_exr(bytes, name, nullptr, alpha, &image.had_own_primaries);
  image.size = pixels.size;
  image.texels.reserve(pixels.pixels.size());
  for (const dvec3& p : pixels.pixels) image.texels.emplace_back(p);
  return image;
}

bool is_exr(std::string_view bytes) { return bytes.starts_with("\x76\x2f\x31\x01"); }

}  // namespace

bool holds_floats(std::string_view bytes) { return is_hdr(bytes) || is_pfm(bytes) || is_exr(bytes); }

bool may_have_alpha(std::string_view bytes) {
  constexpr std::size_t colour_type = 25;
  return is_exr(bytes) || (bytes.starts_with("\x89PNG") && bytes.size() > colour_type && bytes[colour_type] == 6);
}

RgbImage read_image(const std::string& path, Encoding encoding) { return decode_image(read_file(path), path, encoding); }

RgbImage decode_image(const std::string& bytes, const std::string& name, Encoding encoding) {
  RgbImage image;
  if (is_exr(bytes)) {
    image = decode_exr(bytes, name, encoding == Encoding::alpha);
  } else {
    try {
      image = is_hdr(bytes) ? decode_hdr(bytes) : is_pfm(bytes) ? decode_pfm(bytes) : decode_stb(bytes, encoding);
    } catch (const Error& e) {
      throw Error(fmt::format("cannot read '{}' as an image: {}", name, e.what()));
    }
  }
  if (encoding == Encoding::alpha && (is_hdr(bytes) || is_pfm(bytes))) image.texels.assign(image.texels.size(), Rgb(1));
  for (std::size_t i = 0; i < image.texels.size(); ++i) {
    Rgb& texel = image.texels[i];
    if (is_finite(texel)) [[likely]]
      continue;
    const auto width = static_cast<std::size_t>(image.size.x);
    if (image.not_finite++ < RgbImage::most_listed) image.first_not_finite.emplace_back(i % width, i / width);
    for (int c = 0; c < 3; ++c)
      if (!std::isfinite(texel[c])) texel[c] = 0;
  }
  return image;
}

// Chunks are a length, a type, so many bytes, and a sum; gAMA is 100,000 over the exponent and stands before the data.
float stated_gamma(std::string_view bytes) {
  if (!bytes.starts_with("\x89PNG")) return 0;
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i)
      value = 256 * value + static_cast<unsigned char>(bytes[i]);
    return value;
  };
  float gamma = 0;
  for (std::size_t at = 8; at + 12 <= bytes.size(); at += 12 + std::size_t{number(at)}) {
    const std::string_view type = bytes.substr(at + 4, 4);
    if (type == "sRGB") return 0;
    if (type == "IDAT") break;
    if (const std::uint32_t stated = number(at + 8); type == "gAMA" && stated > 0) gamma = 1e5f / static_cast<float>(stated);
  }
  return gamma;
}

void decode_gamma(RgbImage& image, float gamma) {
  for (Rgb& texel : image.texels)
    for (int c = 0; c < 3; ++c) {
      const float value = std::max(texel[c], 0.0f);
      texel[c] = gamma > 0           ? math::pow(value, gamma)
                 : value <= 0.04045f ? value / 12.92f
                                     : math::pow((value + 0.055f) / 1.055f, 2.4f);
    }
}

int repeat_texels(RgbImage& image, const Location& where) {
  constexpr double most_texels = 1 << 20;
  const double affordable = std::sqrt(most_texels / (static_cast<double>(image.size.x) * image.size.y));
  const int times = static_cast<int>(std::clamp(affordable, 1.0, 16.0));
  if (times == 1) return 1;
  const std::size_t count = image.texels.size() * static_cast<std::size_t>(times) * times;
  require_memory(static_cast<double>(count * sizeof(Rgb)), where, "an image whose texels are repeated",
                 "fewer of them, or interpolated ones");
  std::vector<Rgb> texels;
  texels.reserve(count);
  const ivec2 size = times * image.size;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x)
      texels.push_back(image.texels[static_cast<std::size_t>(y / times) * image.size.x + x / times]);
  image.size = size;
  image.texels = std::move(texels);
  return times;
}

Image read_as_image(const std::string& path, std::vector<std::string>& warnings,
                    std::map<std::string, std::string>* attributes) {
  const auto tell = [&](std::size_t count, std::size_t of, const char* consequence, ivec2 first) {
    if (count > 0)
      warnings.push_back(fmt::format("{}: {} of {} pixels are not finite{}, the first at ({}, {})", path, count, of,
                                     consequence, first.x, first.y));
  };
  if (path.ends_with(".exr")) {
    Image image = read_exr(path, attributes);
    std::size_t count = 0, first = 0;
    for (std::size_t i = image.pixels.size(); i-- > 0;)
      if (!is_finite(Rgb(image.pixels[i]))) {
        ++count;
        first = i;
      }
    const auto width = static_cast<std::size_t>(image.size.x);
    tell(count, image.pixels.size(), "", {first % width, first / width});
    return image;
  }
  const RgbImage read = read_image(path);
  tell(read.not_finite, read.texels.size(), " and count as 0", read.not_finite > 0 ? read.first_not_finite.front() : ivec2(0));
  Image image(read.size);
  std::copy(read.texels.begin(), read.texels.end(), image.pixels.begin());
  return image;
}

std::vector<std::uint8_t> encode_png(const std::uint8_t* rgb, ivec2 size) {
  CHECK(rgb != nullptr && size.x > 0 && size.y > 0);
  std::vector<std::uint8_t> bytes;
  const auto append = [](void* context, void* data, int count) {
    const auto* begin = static_cast<const std::uint8_t*>(data);
    static_cast<std::vector<std::uint8_t>*>(context)->insert(static_cast<std::vector<std::uint8_t>*>(context)->end(), begin,
                                                             begin + count);
  };
  CHECK(stbi_write_png_to_func(append, &bytes, size.x, size.y, 3, rgb, 3 * size.x) != 0);
  return bytes;
}

}  // namespace etendue
