#include "integrators/caches/terminate_in_cache.h"

#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <algorithm>
#include <cmath>

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

namespace {

double light_of(const dvec3& c) { return luminance(Rgb(c)); }

// Do points differ by more in the share that they keep than the one of all may stand for? Each has two estimates of its light,
// whole and with an event less, of which each says how far off the share of all is there: their product has the mean of the
// square, free of their noise.
bool shares_vary(std::span<const dvec3> whole, std::span<const dvec3> less, double kept) {
  constexpr double most = 0.02, fewest = 8;
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i + 1 < whole.size(); i += 2) {
    const double a = light_of(whole[i]), b = light_of(whole[i + 1]);
    if (!(a > 0 && b > 0)) continue;
    const double x = light_of(less[i]) / a - kept, y = light_of(less[i + 1]) / b - kept;
    n += 1;
    sum += x * y;
    squares += square(square(x - y) / 2) / 3;  // of their noise alone, which is about normal
  }
  if (n < fewest) return true;
  const double error_of_sum = std::sqrt(squares);
  return sum - 2 * error_of_sum > n * square(most);
}

}  // namespace

std::vector<Rgb> kept_below_limit(const RenderContext& context, CacheSettings settings, std::span<const CachePoint> seen,
                                  const PathSettings& paths, bool cache_direct, const PathCaustics* caustics) {
  constexpr std::size_t points = 32;
  constexpr int rays = 256;  // by which shares of one scene are told apart
  if (paths.max_depth > shared_above) return {};
  settings.strata = HemisphereStrata::of(rays);
  std::vector<std::uint64_t> pixels;
  int deepest = -1;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i]) pixels.push_back(i);
    deepest = std::max(deepest, seen[i].depth);
  }
  const std::size_t some = std::min(points, pixels.size());
  std::partial_sort(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(some), pixels.end(),
                    [](std::uint64_t a, std::uint64_t b) { return mix_bits(a) < mix_bits(b); });
  // Paths have limits from the whole one down to one event less than the deepest level has; there are two of each point.
  const auto limits = static_cast<std::size_t>(deepest + 2);
  const std::size_t estimates = 2 * some;
  std::vector<dvec3> found(limits * estimates);
  parallel_for(found.size(), 1, [&](std::size_t i) {
    const std::size_t estimate = i % estimates;
    const std::uint64_t pixel = pixels[estimate / 2];
    // Events behind the paths are events less, to the caustic map as well; roulette begins as far on.
    const auto behind = static_cast<int>(i / estimates);
    PathSettings settings_behind = paths;
    settings_behind.roulette_depth += behind;
    const auto radiance = [&](std::span<PathSample> samples, int depth) {
      trace_paths(context, samples, depth, settings_behind, cache_direct, nullptr, caustics);
    };
    const std::uint64_t key = hash_keys(pixel, 2u + estimate % 2);
    found[i] = dvec3(sample_hemisphere(context, settings, seen[pixel], 1 + behind, key, 0, radiance).irradiance);
  });
  const auto of_limit = [&](std::size_t limit) { return std::span<const dvec3>(found).subspan(limit * estimates, estimates); };
  std::vector<dvec3> sums(limits, dvec3(0));
  for (std::size_t i = 0; i < found.size(); ++i) sums[i / estimates] += found[i];
  std::vector<Rgb> kept;
  for (std::size_t level = 0; level + 1 < limits && max_component(Rgb(sums[level])) > 0; ++level) {
    if (shares_vary(of_limit(level), of_limit(level + 1), light_of(sums[level + 1]) / light_of(sums[level]))) break;
    kept.emplace_back(1.0f);
    for (int c = 0; c < 3; ++c)
      if (sums[level][c] > 0) kept[level][c] = static_cast<float>(std::clamp(sums[level + 1][c] / sums[level][c], 0.0, 1.0));
  }
  return kept;
}

}  // namespace etendue
