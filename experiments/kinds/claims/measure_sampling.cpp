// Directions and caches: claims about error against time.
//
// Directions: a path tracer over diffuse surfaces alone, that draws them uniformly over the hemisphere (density 1 / 2 pi) or by
// the cosine (density cos / pi). Both are unbiased, so that variance times time is the whole story, and no reference is needed.
// Caches are the product's integrators, run within the harness's own budget loop.
#include "accel/registry.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/structures/stage.h"
#include "experiments/run/reference.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/sampling.h"
#include "framework/transport/direct_light.h"
#include "framework/transport/ray_tools.h"

#include <fmt/format.h>

namespace etendue {

namespace {

enum class Directions : std::uint8_t { uniform, cosine };

class DiffusePaths {
 public:
  // With `sample_lights` direct light is sampled at the lights; else directions must find them.
  DiffusePaths(const Scene& scene, bool sample_lights)
      : scene_(scene),
        sample_lights_(sample_lights),
        rays_(find_ray_structure("binned-sah", {}).make(scene, {})),
        stage_(scene, *rays_, ivec2(0), 0) {}

  Rgb radiance(Ray ray, Directions directions, Sampler& sampler) const {
    constexpr int longest = 6;
    const RenderContext& context = stage_.context();
    Rgb sum(0), throughput(1);
    for (int depth = 0;; ++depth) {
      const Hit hit = trace(context, ray);
      if (!hit) return sum;
      const SurfacePoint point = scene_.surface_at(ray, hit);
      if (point.light != no_id && (depth == 0 || !sample_lights_))
        sum += throughput * context.lights.emitted(point, -ray.direction);
      if (depth == longest) return sum;
      const Bsdf bsdf(scene_, point);
      if (!bsdf.is_diffuse()) throw Error("a surface that is not diffuse; expected diffuse surfaces alone");
      if (sample_lights_) sum += throughput * direct_light(context, point, bsdf, -ray.direction, sampler, MisMode::light);
      const vec3 normal = glm::dot(ray.direction, point.normal) > 0 ? -point.normal : point.normal;
      const vec2 u = sampler.get_2d();
      const vec3 local = directions == Directions::cosine ? sample_cosine_hemisphere(u) : sample_cone(u, 1);
      // f cos / density is albedo / pi cos over cos / pi, or over 1 / 2 pi.
      throughput *= bsdf.diffuse_albedo() * (directions == Directions::cosine ? 1 : 2 * local.z);
      if (is_black(throughput)) return sum;
      ray = spawn_ray(point, Frame::from_normal(normal).to_world(local));
    }
  }

 private:
  const Scene& scene_;
  bool sample_lights_;
  std::unique_ptr<RayQuery> rays_;
  Stage stage_;
};

// Holds of an image by one of the two the mean over pixels of the luminance and of its variance per sample, and its time.
struct Noise {
  double mean = 0, variance = 0, seconds = 0;
  double mean_variance = 0;  // of `mean`
};

Noise render_noise(const DiffusePaths& paths, const Scene& scene, Directions directions, int resolution, std::uint64_t seed) {
  constexpr int samples = 8;
  Noise noise;
  noise.seconds = seconds_of([&] {
    for (int y = 0; y < resolution; ++y)
      for (int x = 0; x < resolution; ++x) {
        double sum = 0, squares = 0;
        for (int s = 0; s < samples; ++s) {
          Sampler sampler(SamplerKind::independent, seed, Stream::camera, pixel_index({x, y}, ivec2(resolution)),
                          static_cast<std::uint32_t>(s));
          const Ray ray = scene.camera.ray(ivec2(resolution), vec2(x, y) + sampler.get_2d(), vec2(0.5f));
          const double value = luminance(paths.radiance(ray, directions, sampler));
          sum += value;
          squares += value * value;
        }
        noise.mean += sum / samples;
        noise.variance += (squares - sum * sum / samples) / (samples - 1);
      }
  });
  const double pixels = static_cast<double>(resolution) * resolution;
  noise.mean /= pixels;
  noise.variance /= pixels;
  noise.mean_variance = noise.variance / samples / pixels;
  return noise;
}

void measure_directions(Trial& t) {
  const int resolution = std::max(32, t.task.resolution / 2);
  for (const auto& [name, sample_lights] : {std::pair<std::string, bool>{"indirect", true}, {"all_light", false}}) {
    const DiffusePaths paths(t.scene, sample_lights);
    std::vector<double> efficiency, variance;
    for (int repetition = 0; repetition < t.task.repetitions; ++repetition) {
      const auto seed = t.task.seed + static_cast<std::uint64_t>(repetition);
      const Noise uniform = render_noise(paths, t.scene, Directions::uniform, resolution, seed);
      const Noise cosine = render_noise(paths, t.scene, Directions::cosine, resolution, seed + 1'000'000);
      efficiency.push_back(uniform.variance * uniform.seconds / (cosine.variance * cosine.seconds));
      variance.push_back(uniform.variance / cosine.variance);
      // Both are estimates of one value: six standard deviations apart they are not.
      const double spread = std::sqrt(uniform.mean_variance + cosine.mean_variance);
      t.disagree(std::abs(uniform.mean - cosine.mean) > 6 * spread);
      t.task.progress((repetition + 1.0) / t.task.repetitions);
    }
    t.count(name, summarise(efficiency));
    t.count(name + "_variance", summarise(variance));
  }
}

// --- caches ---

std::uint64_t rays_of(const CheckpointRecord& record) {
  return find_value(record.counters, "rays").value_or(0) + find_value(record.counters, "shadow_rays").value_or(0);
}

// Error against time, or against the rays asked for.
Curve error_curve(const std::vector<CheckpointRecord>& checkpoints, bool against_rays) {
  Curve curve;
  for (const CheckpointRecord& checkpoint : checkpoints) {
    const double x = against_rays ? static_cast<double>(rays_of(checkpoint)) : checkpoint.time_s;
    if (!curve.empty() && x <= curve.x.back()) continue;
    curve.x.push_back(x);
    curve.y.push_back(checkpoint.metrics.at("relmse"));
  }
  return curve;
}

void measure_cache(Trial& t) {
  const SceneNeeds needs = scene_needs(t.scene);
  const ivec2 resolution(96);
  const Reference reference = make_reference({t.scene, needs, t.task.scene, resolution, {}, 1}, ReferenceCache::standard(""));
  if (!reference.failure.empty()) throw Error(reference.failure);
  const Budget budget{.time_s = 0.012 * t.task.resolution};  // 3 s at 256
  const Method accel{"binned-sah", params_of("layout=bvh16"), {}}, path{"path", {}, {}},
      cache{"irradiance-cache", params_of("samples=256"), {}};
  std::vector<double> lead, last, rays;
  bool censored = false;
  const int rounds = std::max(1, t.task.repetitions / 3);
  for (int round = 0; round < rounds; ++round) {
    const auto run = [&](const Method& method) {
      CellTask task{t.scene, needs, accel, method, t.task.seed + static_cast<std::uint64_t>(round), resolution, budget};
      task.reference = &reference.rendered.image;
      task.metrics = {"relmse"};
      return run_cell(task).checkpoints;
    };
    const auto of_path = run(path), of_cache = run(cache);
    const Curve path_error = error_curve(of_path, false), cache_error = error_curve(of_cache, false);
    last.push_back(path_error.y.back() / cache_error.y.back());
    // The checkpoint at which the cache is furthest ahead of what path tracing had at that time.
    std::size_t at = 0;
    double most = 0;
    for (std::size_t i = 0; i < cache_error.x.size(); ++i) {
      const double error = value_at(path_error, cache_error.x[i]).value_or(path_error.y.back());
      if (error / cache_error.y[i] <= most) continue;
      most = error / cache_error.y[i];
      at = i;
    }
    lead.push_back(most);
    const Arrival arrival = time_to(error_curve(of_path, true), cache_error.y[at]);
    censored = censored || arrival.kind == Arrival::Kind::never;
    rays.push_back(arrival.time / error_curve(of_cache, true).x[at]);
    t.task.progress((round + 1.0) / rounds);
  }
  t.count("lead", summarise(lead));
  t.count("at_end", summarise(last));
  t.count("rays_spared", summarise(rays));
  t.remark(
      fmt::format("{}: 96 x 96, one thread, {:.2g} s. The cache's bias stays while path tracing's error falls on, so that "
                  "the ratio depends on the time{}.",
                  t.task.scene, *budget.time_s,
                  censored ? "; path tracing never reached the cache's error: rays spared are a lower bound" : ""));
}

}  // namespace

std::vector<Measurement> sampling_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {{"directions",
           "variance times time with uniform directions over that with cosine-distributed ones",
           {{"indirect", factor, "lights sampled, variance x time, uniform over cosine"},
            {"all_light", factor, "lights found by chance, variance x time, uniform over cosine"},
            {"indirect_variance", factor, "lights sampled, variance alone"},
            {"all_light_variance", factor, "lights found by chance, variance alone"}},
           measure_directions},
          {"irradiance-cache",
           "relMSE of path tracing over the irradiance cache's, at equal time",
           {{"lead", factor, "error where the cache leads most, path tracing over cache"},
            {"at_end", factor, "error at the end, path tracing over cache"},
            {"rays_spared", factor, "rays to the error of that lead, path tracing over cache"}},
           measure_cache}};
}

}  // namespace etendue
