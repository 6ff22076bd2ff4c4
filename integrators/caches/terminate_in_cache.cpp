#include "integrators/caches/terminate_in_cache.h"

#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <algorithm>

namespace etendue {

TerminateInCache::TerminateInCache(const Scene& scene, const CacheLevels& cache, int depth, bool cache_direct,
                                   const std::optional<Rgb>& kept)
    : scene_(scene), cache_(cache), depth_(depth), kept_(kept) {
  direct = cache_direct ? MisMode::bsdf : MisMode::light;
}

std::optional<Rgb> TerminateInCache::reflected(const SurfacePoint& point, const Diffuse& material, const vec3& wo,
                                               int depth) const {
  // Where the limit matters, paths end one event on and no later: the share that k events less leave is not the k-th power of
  // the share that one leaves.
  if ((kept_ && depth > depth_ + 1) || !takes_records(point, wo)) return std::nullopt;
  const auto found = cache_.interpolate(depth_, point.position, towards(point.shading_normal, point.normal, wo));
  if (!found) return std::nullopt;
  return evaluate(material.reflectance, scene_.textures, point.uv) * found->irradiance * kept_.value_or(Rgb(1)) * inv_pi;
}

std::vector<Rgb> kept_below_limit(const RenderContext& context, const CacheSettings& settings, std::span<const CachePoint> seen,
                                  const PathSettings& paths, bool cache_direct, const PathCaustics* caustics) {
  constexpr std::size_t points = 64;
  if (paths.max_depth > shared_above) return {};
  std::vector<std::uint64_t> pixels;
  int deepest = -1;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i]) pixels.push_back(i);
    deepest = std::max(deepest, seen[i].depth);
  }
  const std::size_t some = std::min(points, pixels.size());
  std::partial_sort(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(some), pixels.end(),
                    [](std::uint64_t a, std::uint64_t b) { return mix_bits(a) < mix_bits(b); });
  // From the whole limit down to one event less than the deepest level has.
  const auto limits = static_cast<std::size_t>(deepest + 2);
  std::vector<dvec3> found(limits * some);
  parallel_for(found.size(), 1, [&](std::size_t i) {
    const std::uint64_t pixel = pixels[i / limits];
    // Events behind the paths are events less, to the caustic map as well; roulette begins as far on.
    const auto behind = static_cast<int>(i % limits);
    PathSettings settings_behind = paths;
    settings_behind.roulette_depth += behind;
    const auto radiance = [&](std::span<PathSample> samples, int depth) {
      trace_paths(context, samples, depth, settings_behind, cache_direct, nullptr, caustics);
    };
    found[i] =
        dvec3(sample_hemisphere(context, settings, seen[pixel], 1 + behind, hash_keys(pixel, 2u), 0, radiance).irradiance);
  });
  std::vector<dvec3> sums(limits, dvec3(0));
  for (std::size_t i = 0; i < found.size(); ++i) sums[i % limits] += found[i];
  std::vector<Rgb> kept;
  for (std::size_t level = 0; level + 1 < limits && max_component(Rgb(sums[level])) > 0; ++level) {
    kept.emplace_back(1.0f);
    for (int c = 0; c < 3; ++c)
      if (sums[level][c] > 0) kept[level][c] = static_cast<float>(std::clamp(sums[level + 1][c] / sums[level][c], 0.0, 1.0));
  }
  return kept;
}

}  // namespace etendue
