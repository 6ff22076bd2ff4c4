#include "framework/io/image/hdr.h"

#include "framework/core/error.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <array>

namespace etendue {

namespace {

class HdrReader {
 public:
  explicit HdrReader(std::string_view bytes) : bytes_(bytes) {}

  RgbImage read() {
    read_header();
    RgbImage image{size_, std::vector<Rgb>(static_cast<std::size_t>(size_.x) * size_.y)};
    std::vector<std::array<std::uint8_t, 4>> row(static_cast<std::size_t>(size_.x));
    for (int y = 0; y < size_.y; ++y) {
      read_row(row);
      for (std::size_t x = 0; x < row.size(); ++x) {
        const auto& p = row[x];
        const float unit = p[3] == 0 ? 0 : std::ldexp(1.0f, p[3] - (128 + 8));
        image.texels[static_cast<std::size_t>(y) * row.size() + x] = unit * Rgb(p[0], p[1], p[2]);
      }
    }
    return image;
  }

 private:
  void read_header() {
    WordReader words(bytes_);
    bool is_rgbe = false;
    for (words.next_line(); !words.at_end(); words.next_line()) {
      const std::string_view word = words.word();
      if (word.empty()) break;
      is_rgbe |= word == "FORMAT=32-bit_rle_rgbe";
    }
    if (!is_rgbe) throw Error("the header has no FORMAT=32-bit_rle_rgbe");
    words.next_line();
    const std::string_view y = words.word(), height = words.word(), x = words.word(), width = words.word();
    const auto h = parse_number(height), w = parse_number(width);
    if (y != "-Y" || x != "+X" || !h || !w) throw Error("expected the resolution as -Y HEIGHT +X WIDTH");
    words.next_line();
    position_ = words.offset();
    // A row takes at least 12 bytes, and a run of 127 values takes two.
    const auto left = static_cast<double>(bytes_.size() - position_);
    if (!(*h >= 1 && *w >= 1 && *h <= 65536 && *w <= 65536 && *h * *w <= left * 128))
      throw Error(fmt::format("the header announces {} x {} pixels, in {} bytes", *w, *h, left));
    size_ = {static_cast<int>(*w), static_cast<int>(*h)};
  }

  std::uint8_t next() {
    if (position_ == bytes_.size()) throw Error("the file ends before its data does");
    return static_cast<std::uint8_t>(bytes_[position_++]);
  }

  void read_row(std::vector<std::array<std::uint8_t, 4>>& row) {
    std::array<std::uint8_t, 4> first{};
    for (std::uint8_t& b : first) b = next();
    const bool run_length = first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (!run_length) {
      row[0] = first;
      for (std::size_t x = 1; x < row.size(); ++x)
        for (std::uint8_t& b : row[x]) b = next();
      return;
    }
    if (std::size_t{first[2]} * 256 + first[3] != row.size()) throw Error("a row of another length than the header states");
    for (std::size_t channel = 0; channel < 4; ++channel)
      for (std::size_t x = 0; x < row.size();) {
        const std::uint8_t code = next();
        const bool repeats = code > 128;
        const std::size_t count = repeats ? code - 128u : code;
        if (count == 0 || count > row.size() - x) throw Error("a damaged run of values");
        const std::uint8_t value = repeats ? next() : std::uint8_t{0};
        for (const std::size_t end = x + count; x < end; ++x) row[x][channel] = repeats ? value : next();
      }
  }

  std::string_view bytes_;
  std::size_t position_ = 0;
  ivec2 size_{0};
};

}  // namespace

bool is_hdr(std::string_view bytes) { return bytes.starts_with("#?RADIANCE") || bytes.starts_with("#?RGBE"); }

RgbImage decode_hdr(std::string_view bytes) { return HdrReader(bytes).read(); }

}  // namespace etendue
