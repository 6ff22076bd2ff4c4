#include "experiments/report/paper/pictures.h"

#include "experiments/statistics/statistics.h"
#include "framework/core/lists.h"
#include "framework/io/image/image_file.h"
#include "framework/io/image/png.h"

#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// The mean over the part of a window that a picture's pixel shows.
dvec3 resampled(const Image& image, const Window& window, ivec2 size, ivec2 pixel) {
  const dvec2 scale = dvec2(window.size) / dvec2(size);
  const ivec2 first = window.begin + ivec2(glm::floor(dvec2(pixel) * scale));
  const ivec2 last = window.begin + ivec2(glm::ceil(dvec2(pixel + 1) * scale - 1e-9));
  dvec3 sum(0);
  const ivec2 end = glm::max(last, first + 1);
  // A larger picture repeats the pixel in which its own begins.
  const ivec2 stop(scale.x < 1 ? first.x + 1 : end.x, scale.y < 1 ? first.y + 1 : end.y);
  for (int y = first.y; y < stop.y; ++y)
    for (int x = first.x; x < stop.x; ++x) sum += image.at(x, y);
  return sum / (static_cast<double>(stop.x - first.x) * (stop.y - first.y));
}

template <class ColourOf>
Canvas painted(ivec2 size, const ColourOf& colour_of) {
  Canvas canvas(size);
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) canvas.set({x, y}, colour_of(ivec2(x, y)));
  return canvas;
}

std::string ascii(std::string_view text) {
  std::string out;
  for (const char c : text)
    if ((static_cast<unsigned char>(c) & 0xc0) != 0x80) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

}  // namespace

Colour difference_colour(const dvec3& image, const dvec3& reference, double white) {
  const double dark = 1e-3 * white;
  const double ratio = (luminance(Rgb(image)) + dark) / (luminance(Rgb(reference)) + dark);
  if (!std::isfinite(ratio)) return {128, 128, 128};
  const double steps = ratio > 0 ? std::clamp(std::log2(ratio), -1.0, 1.0) : -1;
  const auto fading = static_cast<std::uint8_t>(std::lround(255 * (1 - std::abs(steps))));
  return {steps < 0 ? fading : std::uint8_t{255}, fading, steps > 0 ? fading : std::uint8_t{255}};
}

double white_of(const Image& image) {
  const auto values = mapped(image.pixels, [](const dvec3& p) { return std::max({p.x, p.y, p.z}); });
  const double white = values.empty() ? 0 : 1.25 * quantile(values, 0.98);
  return white > 0 ? white : 1;
}

void Canvas::set(ivec2 pixel, const Colour& colour) {
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size_.x || pixel.y >= size_.y) return;
  std::ranges::copy(colour, bytes_.begin() + 3 * (static_cast<std::ptrdiff_t>(pixel.y) * size_.x + pixel.x));
}

void Canvas::draw(const Canvas& picture, ivec2 at) {
  for (int y = 0; y < picture.size_.y; ++y)
    for (int x = 0; x < picture.size_.x; ++x) {
      const std::uint8_t* from = &picture.bytes_[3 * (static_cast<std::size_t>(y) * picture.size_.x + x)];
      set(at + ivec2(x, y), {from[0], from[1], from[2]});
    }
}

void Canvas::frame(const Window& window, const Colour& colour, int width) {
  for (int y = 0; y < window.size.y; ++y)
    for (int x = 0; x < window.size.x; ++x)
      if (std::min({x, y, window.size.x - 1 - x, window.size.y - 1 - y}) < width) set(window.begin + ivec2(x, y), colour);
}

int Canvas::text(ivec2 at, std::string_view text, int scale) {
  struct Corner {
    float x, y, z;
    std::uint8_t colour[4];
  };
  std::string plain = ascii(text);
  std::vector<Corner> corners(4 * 64 * (plain.size() + 1));  // a letter has fewer strokes
  const int quads =
      stb_easy_font_print(0, 0, plain.data(), nullptr, corners.data(), static_cast<int>(corners.size() * sizeof(Corner)));
  for (int quad = 0; quad < quads; ++quad) {
    const Corner &first = corners[4 * static_cast<std::size_t>(quad)],
                 &opposite = corners[4 * static_cast<std::size_t>(quad) + 2];
    const ivec2 begin = scale * ivec2(vec2(first.x, first.y)), end = scale * ivec2(vec2(opposite.x, opposite.y));
    for (int y = begin.y; y < end.y; ++y)
      for (int x = begin.x; x < end.x; ++x) set(at + ivec2(x, y), {0, 0, 0});
  }
  return text_pixels(text, scale);
}

std::string Canvas::png() const {
  const std::vector<std::uint8_t> bytes = encode_png(bytes_.data(), size_);
  return {bytes.begin(), bytes.end()};
}

int text_pixels(std::string_view text, int scale) {
  std::string plain = ascii(text);
  return scale * stb_easy_font_width(plain.data());
}

Canvas picture_of(const Image& image, const Window& window, ivec2 size, double exposure) {
  return painted(size, [&](ivec2 pixel) {
    const dvec3 value = exposure * resampled(image, window, size, pixel);
    return Colour{linear_to_srgb_byte(value.x), linear_to_srgb_byte(value.y), linear_to_srgb_byte(value.z)};
  });
}

Canvas difference_of(const Image& image, const Image& reference, const Window& window, ivec2 size) {
  return painted(size, [&, white = white_of(reference)](ivec2 pixel) {
    return difference_colour(resampled(image, window, size, pixel), resampled(reference, window, size, pixel), white);
  });
}

}  // namespace etendue
