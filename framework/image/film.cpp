#include "framework/image/film.h"

#include <xxhash.h>
#include <tuple>

namespace etendue {

Image part_of(const Image& image, ivec2 begin, ivec2 end) {
  Image part(end - begin);
  for (int y = begin.y; y < end.y; ++y)
    for (int x = begin.x; x < end.x; ++x) part.at(x - begin.x, y - begin.y) = image.at(x, y);
  return part;
}

std::uint64_t hash_of(const Image& image) { return XXH3_64bits(image.pixels.data(), image.pixels.size() * sizeof(dvec3)); }

void Film::add(ivec2 pixel, const Rgb& value, std::uint32_t iteration, double weight) {
  const std::size_t i = pixel_index(pixel, sum_.size);
  if (is_finite(value)) [[likely]]
    sum_.pixels[i] += weight * dvec3(value);
  else
    record_non_finite(pixel, iteration);
  weight_[i] += weight;
}

void Film::set(ivec2 pixel, const dvec3& value) {
  const std::size_t i = pixel_index(pixel, sum_.size);
  sum_.pixels[i] = value;
  weight_[i] = 1;
}

Image Film::mean() const {
  Image image(sum_.size);
  for (std::size_t i = 0; i < weight_.size(); ++i)
    if (weight_[i] != 0) image.pixels[i] = sum_.pixels[i] / weight_[i];
  return image;
}

void Film::record_non_finite(ivec2 pixel, std::uint32_t iteration) {
  constexpr std::size_t kept = 16;
  const std::lock_guard lock(non_finite_mutex_);
  ++non_finite_count_;
  // Which ones are kept must not depend on the order in which threads come here.
  non_finite_.push_back({pixel, iteration});
  std::sort(non_finite_.begin(), non_finite_.end(), [](const auto& a, const auto& b) {
    return std::tie(a.iteration, a.pixel.y, a.pixel.x) < std::tie(b.iteration, b.pixel.y, b.pixel.x);
  });
  if (non_finite_.size() > kept) non_finite_.pop_back();
}

}  // namespace etendue
