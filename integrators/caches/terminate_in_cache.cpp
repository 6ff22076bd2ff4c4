#include "integrators/caches/terminate_in_cache.h"

#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <algorithm>

namespace etendue {

TerminateInCache::TerminateInCache(const Scene& scene, const CacheLevels& cache, int depth, bool cache_direct, const Rgb& kept)
    : scene_(scene), cache_(cache), depth_(depth), kept_(kept) {
  direct = cache_direct ? MisMode::bsdf : MisMode::light;
}

std::optional<Rgb> TerminateInCache::reflected(const SurfacePoint& point, const Diffuse& material, const vec3& wo,
                                               int depth) const {
  // Where the limit matters, paths end one event on and no later: the share that k events less leave is not the k-th power of
  // the share that one leaves.
  if ((kept_ != Rgb(1) && depth > depth_ + 1) || !shows_one_side(point, wo)) return std::nullopt;
  const auto found = cache_.interpolate(depth_, point.position, towards(point.shading_normal, point.normal, wo));
  if (!found) return std::nullopt;
  return evaluate(material.reflectance, scene_.textures, point.uv) * found->irradiance * kept_ * inv_pi;
}

Rgb kept_below_limit(const RenderContext& context, const CacheSettings& settings, std::span<const CachePoint> seen,
                     const PathSettings& paths, bool cache_direct, const PathCaustics* caustics) {
  constexpr std::size_t points = 64;
  if (paths.max_depth > shared_above) return Rgb(1);
  std::vector<std::uint64_t> pixels;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i].depth == 0) pixels.push_back(i);
  const std::size_t some = std::min(points, pixels.size());
  std::partial_sort(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(some), pixels.end(),
                    [](std::uint64_t a, std::uint64_t b) { return mix_bits(a) < mix_bits(b); });
  std::vector<dvec3> whole(some), less(some);
  parallel_for(2 * some, 1, [&](std::size_t i) {
    const std::uint64_t pixel = pixels[i / 2];
    PathSettings limited = paths;
    limited.max_depth -= static_cast<int>(i % 2);
    const auto radiance = [&](std::span<PathSample> samples, int depth) {
      trace_paths(context, samples, depth, limited, cache_direct, nullptr, caustics);
    };
    const IrradianceEstimate e = sample_hemisphere(context, settings, seen[pixel], 1, hash_keys(pixel, 2u), 0, radiance);
    (i % 2 == 0 ? whole : less)[i / 2] = dvec3(e.irradiance);
  });
  dvec3 sum(0), sum_less(0);
  for (std::size_t i = 0; i < some; ++i) {
    sum += whole[i];
    sum_less += less[i];
  }
  Rgb kept(1);
  for (int c = 0; c < 3; ++c)
    if (sum[c] > 0) kept[c] = static_cast<float>(std::clamp(sum_less[c] / sum[c], 0.0, 1.0));
  return kept;
}

}  // namespace etendue
