#include "framework/io/image/exr.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/memory.h"
#include "framework/io/text.h"

#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

namespace etendue {

namespace {

constexpr std::array<const char*, 3> rgb_names{"R", "G", "B"}, xyz_names{"X", "Y", "Z"};
constexpr int most_pixels_across = 65536;

std::string channel_names(const Imf::ChannelList& channels) {
  std::string names;
  for (auto c = channels.begin(); c != channels.end(); ++c) names += (names.empty() ? "" : ", ") + std::string(c.name());
  return names.empty() ? "none" : names;
}

// The channels that make R, G and B: themselves, X, Y and Z, or Y three times.
std::array<const char*, 3> find_channels(const Imf::ChannelList& channels, bool alpha) {
  const auto has = [&](const auto& names) {
    return std::ranges::all_of(names, [&](const char* name) { return channels.findChannel(name) != nullptr; });
  };
  const bool has_rgb = has(rgb_names);
  if (!has_rgb && !channels.findChannel("Y"))
    throw Error("expected channels R, G and B, or Y; found " + channel_names(channels));
  if (!has_rgb && (channels.findChannel("RY") || channels.findChannel("BY")))
    throw Error("luminance and chroma, " + channel_names(channels) + "; expected channels R, G and B, or Y alone");
  std::array<const char*, 3> found{"Y", "Y", "Y"};
  if (has_rgb) found = rgb_names;
  if (!has_rgb && has(xyz_names)) found = xyz_names;
  if (alpha) found.fill("A");
  for (const char* name : found) {
    const Imf::Channel& channel = channels[name];
    if (channel.xSampling != 1 || channel.ySampling != 1) throw Error(fmt::format("channel {} is subsampled", name));
  }
  return found;
}

// The matrix that makes linear sRGB of colours that are X, Y and Z or have primaries of their own (row vectors on its left);
// none where they are sRGB's. A white of its own stays as it is: nothing adapts to it.
std::optional<Imath::M44f> conversion_to_srgb(const Imf::Header& header, std::string_view first_channel) {
  const Imf::Chromaticities srgb;
  if (first_channel == "X") return Imf::XYZtoRGB(srgb, 1);
  if (first_channel != "R" || !Imf::hasChromaticities(header)) return std::nullopt;
  const Imf::Chromaticities& own = Imf::chromaticities(header);
  const auto is_same = [](const Imath::V2f& a, const Imath::V2f& b) { return (a - b).length2() <= 1e-6f; };
  if (is_same(own.red, srgb.red) && is_same(own.green, srgb.green) && is_same(own.blue, srgb.blue) &&
      is_same(own.white, srgb.white))
    return std::nullopt;
  const Imath::M44f conversion = Imf::RGBtoXYZ(own, 1) * Imf::XYZtoRGB(srgb, 1);
  for (const auto& row : conversion.x)
    for (const float element : row)
      if (!std::isfinite(element)) throw Error("chromaticities that make no colours");
  return conversion;
}

// The highest compression ratio that a codec can reach. Deflate reaches 1 : 1032; the last figure is a bound for the rest,
// whose flat areas cost next to nothing.
std::int64_t most_packed(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
      return 1;
    case Imf::RLE_COMPRESSION:
      return 128;
    case Imf::ZIPS_COMPRESSION:
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 1032;
    default:
      return 20000;
  }
}

// Checks the size a header states against the file's length before anything is allocated. A pixel takes at least two bytes.
ivec2 checked_size(const Imf::Header& header, std::size_t file_bytes) {
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1,
                     height = std::int64_t{window.max.y} - window.min.y + 1;
  const bool sensible = width >= 1 && height >= 1 && width <= most_pixels_across && height <= most_pixels_across &&
                        width * height <= (std::int64_t{1} << 27);
  if (!sensible || 2 * width * height > static_cast<std::int64_t>(file_bytes) * most_packed(header.compression()))
    throw Error(fmt::format("the header announces {} x {} pixels, in a file of {} bytes", width, height, file_bytes));
  if (width * height > (1 << 20))
    require_memory(static_cast<double>(width * height) * (3 * sizeof(float) + sizeof(dvec3)), {}, "the image", "fewer pixels");
  return {static_cast<int>(width), static_cast<int>(height)};
}

// The size that OpenEXR reads for an attribute of a type, whatever size the file states; nothing where it goes by the file.
std::optional<std::size_t> fixed_size(std::string_view type) {
  struct Entry {
    std::string_view type;
    std::size_t size;
  };
  static constexpr Entry entries[] = {{"box2f", 16},
                                      {"box2i", 16},
                                      {"chromaticities", 32},
                                      {"compression", 1},
                                      {"deepImageState", 1},
                                      {"double", 8},
                                      {"envmap", 1},
                                      {"float", 4},
                                      {"int", 4},
                                      {"keycode", 28},
                                      {"lineOrder", 1},
                                      {"m33d", 72},
                                      {"m33f", 36},
                                      {"m44d", 128},
                                      {"m44f", 64},
                                      {"rational", 8},
                                      {"tiledesc", 9},
                                      {"timecode", 8},
                                      {"v2d", 16},
                                      {"v2f", 8},
                                      {"v2i", 8},
                                      {"v3d", 24},
                                      {"v3f", 12},
                                      {"v3i", 12}};
  for (const Entry& entry : entries)
    if (entry.type == type) return entry.size;
  return std::nullopt;
}

// Passes over the headers' attributes before OpenEXR does, which allocates whatever sizes they state before it reads them.
class HeaderCheck {
 public:
  explicit HeaderCheck(std::string_view bytes) : bytes_(bytes) {}

  void run() {
    const bool multi_part = bytes_.size() > 5 && (bytes_[5] & 0x10);
    bool header_is_empty = true;
    while (position_ < bytes_.size()) {
      if (text().empty()) {  // the end of a header; several end with an empty one
        if (!multi_part || header_is_empty) return;
        header_is_empty = true;
        continue;
      }
      header_is_empty = false;
      const std::string_view type = text();
      const std::uint32_t size = number();
      const std::size_t end = position_ + size;
      if (end > bytes_.size()) throw Error(fmt::format("an attribute of {} bytes, in a file of {}", size, bytes_.size()));
      if (type == "chlist") {
        while (!text().empty()) position_ += 16;
      } else if (type == "preview") {
        const std::uint64_t width = number(), height = number();
        position_ += 4 * std::min<std::uint64_t>(width * height, bytes_.size());
      } else {
        position_ += fixed_size(type).value_or(size);
      }
      if (position_ != end) throw Error(fmt::format("a damaged attribute of type {}", quote(type)));
    }
  }

 private:
  std::string_view text() {
    const std::size_t begin = std::min(position_, bytes_.size()), end = std::min(bytes_.find('\0', begin), bytes_.size());
    position_ = end + 1;
    return bytes_.substr(begin, end - begin);
  }
  std::uint32_t number() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i, ++position_)
      if (position_ < bytes_.size()) value |= std::uint32_t{static_cast<unsigned char>(bytes_[position_])} << (8 * i);
    return value;
  }

  std::string_view bytes_;
  std::size_t position_ = 8;  // after the magic number and the version
};

// A file is read once, into memory: what was checked is what is decoded.
class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(std::string_view bytes, const std::string& name) : Imf::IStream(name.c_str()), bytes_(bytes) {}

  bool read(char* to, int count) override {
    if (count < 0 || static_cast<std::uint64_t>(count) > bytes_.size() - position_)
      throw Error("the file ends before its data does");
    std::memcpy(to, bytes_.data() + position_, static_cast<std::size_t>(count));
    position_ += static_cast<std::uint64_t>(count);
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = std::min<std::uint64_t>(position, bytes_.size()); }

 private:
  std::string_view bytes_;
  std::uint64_t position_ = 0;
};

Image read_pixels(const std::string& name, std::string_view bytes, std::map<std::string, std::string>* attributes, bool alpha,
                  bool* had_own_primaries) {
  // OpenEXR allocates its table of offsets before it hands out the header.
  Imf::Header::setMaxImageSize(most_pixels_across, most_pixels_across);
  Imf::Header::setMaxTileSize(most_pixels_across, most_pixels_across);
  HeaderCheck(bytes).run();
  MemoryStream stream(bytes, name);
  Imf::InputFile file(stream);
  const Imf::Header& header = file.header();
  const Imath::Box2i window = header.dataWindow();
  const ivec2 size = checked_size(header, bytes.size());
  if (alpha && !header.channels().findChannel("A")) {
    Image opaque(size);
    std::ranges::fill(opaque.pixels, dvec3(1));
    return opaque;
  }
  const auto names = find_channels(header.channels(), alpha);

  std::vector<float> planes(static_cast<std::size_t>(size.x) * size.y * 3);
  Imf::FrameBuffer buffer;
  constexpr std::size_t x_stride = 3 * sizeof(float);
  const std::size_t y_stride = x_stride * static_cast<std::size_t>(size.x);
  const auto conversion = conversion_to_srgb(header, names[0]);
  if (had_own_primaries) *had_own_primaries = conversion && std::string_view(names[0]) == "R";
  const bool grey = names[0] == names[1];
  for (int i = 0; i < (grey ? 1 : 3); ++i) {
    buffer.insert(names[i], Imf::Slice::Make(Imf::FLOAT, planes.data() + i, window, x_stride, y_stride));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);

  Image image(size);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float* p = &planes[3 * i];
    image.pixels[i] = grey ? dvec3(p[0]) : dvec3(p[0], p[1], p[2]);
    if (!conversion) continue;
    const Imath::V3d converted = Imath::V3d(p[0], p[1], p[2]) * *conversion;
    image.pixels[i] = {converted.x, converted.y, converted.z};
  }
  if (attributes)
    for (auto a = header.begin(); a != header.end(); ++a)
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute())) (*attributes)[a.name()] = text->value();
  return image;
}

// OpenEXR's own streams leave errors of the last write, which a destructor makes, unsaid.
class ByteStream final : public Imf::OStream {
 public:
  ByteStream() : Imf::OStream("memory") {}

  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    bytes_.resize(std::max(bytes_.size(), position_ + size));
    std::copy(data, data + count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
    position_ += size;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

}  // namespace

std::string encode_exr(const Image& image, const std::map<std::string, std::string>& attributes) {
  CHECK(image.size.x > 0 && image.size.y > 0);
  std::vector<float> planes;
  planes.reserve(image.pixels.size() * 3);
  for (const dvec3& p : image.pixels)
    for (int c = 0; c < 3; ++c) planes.push_back(static_cast<float>(p[c]));
  Imf::Header header(image.size.x, image.size.y);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [name, value] : attributes) header.insert(name, Imf::StringAttribute(value));
  Imf::FrameBuffer buffer;
  constexpr std::size_t x_stride = 3 * sizeof(float);
  for (int c = 0; c < 3; ++c) {
    header.channels().insert(rgb_names[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(rgb_names[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(planes.data() + c), x_stride,
                                           x_stride * static_cast<std::size_t>(image.size.x)));
  }
  ByteStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(image.size.y);
  }
  return stream.take();
}

FileStamp write_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& attributes) {
  return write_whole_file(path, encode_exr(image, attributes));
}

Image parse_exr(std::string_view bytes, const std::string& name, std::map<std::string, std::string>* attributes, bool alpha,
                bool* had_own_primaries) {
  try {
    return read_pixels(name, bytes, attributes, alpha, had_own_primaries);
  } catch (const std::exception& e) {
    throw Error(fmt::format("cannot read '{}' as OpenEXR: {}", name, e.what()));
  }
}

Image read_exr(const std::string& path, std::map<std::string, std::string>* attributes) {
  return parse_exr(read_file(path), path, attributes);
}

}  // namespace etendue
