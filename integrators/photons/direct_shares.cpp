#include "integrators/photons/direct_shares.h"

#include "framework/core/parallel.h"
#include "integrators/paths/sample_shares.h"

namespace etendue {

namespace {

constexpr std::uint32_t first_look = 1, whole_look = 8;  // paths of a pilot's pixel: by default, and where neighbours differed
constexpr float contrast = 4;                            // of their luminances, as a ratio
constexpr float most = 7;  // which leave an eighth of the variance; deep paths through glass are not cheap

// Parts of a pixel's sequence of camera samples beyond those that iterations use (framework/core/sampler.h).
constexpr std::uint32_t first_of_further = 1u << 26, first_of_pilot = 2u << 26;

Rgb found_along(const PhotonCameraPath& walk, ivec2 pixel, SamplerKind kind, std::uint32_t index, bool direct) {
  PathSample path = camera_path(walk.context, pixel, kind, index);
  Rgb reflected(0);
  const Rgb met = walk(path.ray, path.sampler, path.sampler,
                       [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int, float) {
                         if (!direct) return;
                         reflected += throughput * direct_light(walk.context, point, bsdf, wo, path.sampler, MisMode::light);
                       });
  return met + reflected;
}

void look(const PhotonCameraPath& walk, SamplerKind kind, bool direct, const Tile& tile, SampleShares& seen) {
  bool differs = false;
  for (std::uint32_t i = 0; i < (differs ? whole_look : first_look); ++i) {
    float left = 0;
    for_pixels(tile, [&](ivec2 pixel) {
      const float found = luminance(found_along(walk, pixel, kind, first_of_pilot + i, direct));
      if (pixel.x > tile.begin.x) differs = differs || std::max(found, left) > contrast * std::min(found, left);
      left = found;
      seen.add(pixel_index(pixel, walk.context.resolution), found);
    });
  }
}

}  // namespace

// A filter with negative lobes divides by the sum of the pixel's own weights, of which further paths have none.
DirectShares::DirectShares(const PhotonCameraPath& walk, SamplerKind sampler, float further, bool direct)
    : sampler_(sampler), direct_(direct) {
  if (!(further > 0) || has_signed_filter(walk.context)) return;
  const ivec2 resolution = walk.context.resolution;
  SampleShares seen(resolution, 0, 0, true);
  parallel_for(path_tile_count(resolution), 1,
               [&](std::size_t number) { look(walk, sampler, direct, path_tile(resolution, number), seen); });
  seen.end_iteration();
  std::vector<std::uint8_t> counts(static_cast<std::size_t>(resolution.x) * resolution.y);
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] = static_cast<std::uint8_t>(std::min(further * seen.deviation(i), most));
  if (std::ranges::any_of(counts, [](std::uint8_t n) { return n > 0; })) further_ = std::move(counts);
}

Rgb DirectShares::further(const PhotonCameraPath& walk, ivec2 pixel, std::uint32_t iteration) const {
  const auto key = pixel_index(pixel, walk.context.resolution);
  const std::uint32_t paths = count(key);
  Rgb sum(0);
  for (std::uint32_t i = 0; i < paths; ++i)
    sum += found_along(walk, pixel, sampler_, first_of_further + iteration * paths + i, direct_);
  return share(key) * sum;
}

}  // namespace etendue
