#include "integrators/photons/direct_shares.h"

#include "framework/core/parallel.h"
#include "integrators/paths/path_choices.h"
#include "integrators/paths/sample_shares.h"

#include <cmath>
#include <numeric>
#include <optional>

namespace etendue {

namespace {

constexpr std::uint32_t first_look = 1, whole_look = 4;  // paths of a pilot's pixel: by default, and where pixels differ
constexpr float contrast = 4;                            // of one pixel and the next that is a difference, as a ratio
constexpr float most_further = 7;  // leave an eighth of the variance; deep paths through glass are not cheap

// Parts of a pixel's sequence of camera samples beyond those that iterations use (framework/core/sampler.h).
constexpr std::uint32_t first_of_further = 1u << 26, first_of_pilot = 2u << 26;

using Direct = std::optional<MisMode>;

// What a camera path finds of emission, and where `direct` is given, of direct light.
Rgb camera_radiance(const PhotonCameraPath& walk, ivec2 pixel, SamplerKind kind, std::uint32_t index, Direct direct) {
  PathSample path = camera_path(walk.context, pixel, kind, index);
  Rgb reflected(0);
  const Rgb met = walk(path.ray, path.sampler, path.sampler,
                       [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int, float) {
                         if (!direct) return;
                         reflected += throughput * all_direct_light(walk.context, point, bsdf, wo, path.sampler, *direct);
                       });
  return met + reflected;
}

// A column or a single pixel has no other beside it.
void run_pilot(const PhotonCameraPath& walk, SamplerKind kind, Direct direct, const Tile& tile, SampleShares& seen) {
  bool differ = tile.end.x - tile.begin.x == 1;
  for (std::uint32_t i = 0; i < (differ ? whole_look : first_look); ++i) {
    std::optional<float> last;
    for_pixels(tile, [&](ivec2 pixel) {
      const float found = luminance(camera_radiance(walk, pixel, kind, first_of_pilot + i, direct));
      differ = differ || (last && std::max(found, *last) > contrast * std::min(found, *last));
      last = found;
      seen.add(pixel_index(pixel, walk.context.resolution), found);
    });
  }
}

// Luminance of the image, by a path in each tile.
double mean_luminance(const PhotonCameraPath& walk, SamplerKind kind, Direct direct) {
  std::vector<float> found(path_tile_count(walk.context.resolution));
  parallel_for(found.size(), 16, [&](std::size_t number) {
    const ivec2 pixel = path_tile(walk.context.resolution, number).begin;
    found[number] = luminance(camera_radiance(walk, pixel, kind, first_of_pilot + whole_look, direct));
  });
  std::erase_if(found, [](float luminance) { return !std::isfinite(luminance); });
  return std::accumulate(found.begin(), found.end(), 0.0) / static_cast<double>(std::max<std::size_t>(found.size(), 1));
}

// Is any of it shown, or beside what is?
bool is_shown(const RenderContext& context, const Tile& tile) {
  const Tile shown = context.seen({tile.begin - 1, tile.end + 1});
  return shown.begin.x < shown.end.x && shown.begin.y < shown.end.y;
}

}  // namespace

// A filter with negative lobes divides by the sum of the pixel's own weights, of which further paths have none.
DirectShares::DirectShares(const PhotonCameraPath& walk, SamplerKind sampler, float further, bool direct) : sampler_(sampler) {
  const auto timed = walk.context.phases.measure("pilot");
  direct_ = direct ? Direct(choose_direct(walk.context)) : std::nullopt;
  if (!(further > 0) || has_signed_filter(walk.context)) return;
  const ivec2 resolution = walk.context.resolution;
  SampleShares seen(resolution, 0, 0, true);
  seen.know_mean(mean_luminance(walk, sampler, direct_));  // the same for a part of the image as for the whole
  parallel_for(path_tile_count(resolution), 1, [&](std::size_t number) {
    const Tile tile = path_tile(resolution, number);
    if (is_shown(walk.context, tile)) run_pilot(walk, sampler, direct_, tile, seen);
  });
  seen.end_iteration();
  std::vector<std::uint8_t> counts(static_cast<std::size_t>(resolution.x) * resolution.y);
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] = static_cast<std::uint8_t>(std::min(further * seen.deviation(i), most_further));
  if (std::ranges::any_of(counts, [](std::uint8_t n) { return n > 0; })) further_ = std::move(counts);
}

Rgb DirectShares::further(const PhotonCameraPath& walk, ivec2 pixel, std::uint32_t iteration) const {
  const auto key = pixel_index(pixel, walk.context.resolution);
  const std::uint32_t paths = count(key);
  Rgb sum(0);
  for (std::uint32_t i = 0; i < paths; ++i)
    sum += camera_radiance(walk, pixel, sampler_, first_of_further + iteration * paths + i, direct_);
  return share(key) * sum;
}

}  // namespace etendue
