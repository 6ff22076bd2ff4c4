#include "experiments/kinds/structures/accel_rays.h"

#include "experiments/kinds/structures/stage.h"
#include "experiments/kinds/timing.h"
#include "framework/core/parallel.h"
#include "framework/core/sampling.h"
#include "framework/transport/ray_tools.h"
#include "integrators/paths/path.h"
#include "integrators/paths/path_choices.h"
#include "integrators/registry.h"

#include <xxhash.h>

#include <unordered_set>

namespace etendue {

namespace {

constexpr std::size_t run_length = 64;
constexpr std::int64_t path_events = 5, gather_rays = 16;
constexpr int gather_side = 4;  // a gather stands for gather_side^2 pixels

std::uint64_t hash_of(const Ray& ray) {
  const float values[]{ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z};
  return XXH3_64bits(values, sizeof values);
}

// A structure that writes down what it is asked, by one thread.
class RecordingQuery final : public RayQuery {
 public:
  explicit RecordingQuery(const RayQuery& inner) : inner_(inner) {}

  // Notes the rays that are asked from now on (nullptr: none): rays of closest() to `primary` if they are among `camera`, else
  // to `others`; those of occluded() to `shadow`.
  void record(const std::unordered_set<std::uint64_t>* camera, std::vector<Ray>* primary, std::vector<Ray>* others,
              std::vector<Ray>* shadow) {
    camera_ = camera;
    primary_ = primary;
    others_ = others;
    shadow_ = shadow;
  }

  Hit closest(const Ray& ray) const override {
    if (std::vector<Ray>* to = camera_ && camera_->contains(hash_of(ray)) ? primary_ : others_) to->push_back(ray);
    return inner_.closest(ray);
  }
  bool occluded(const Ray& ray) const override {
    if (shadow_) shadow_->push_back(ray);
    return inner_.occluded(ray);
  }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = closest(rays[i]);
  }
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const override {
    for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = this->occluded(rays[i]);
  }
  Hit passed_light(const Ray& ray) const override { return inner_.passed_light(ray); }
  Hit closest_counted(const Ray& ray, TraversalCounters&) const override { return closest(ray); }
  bool occluded_counted(const Ray& ray, TraversalCounters&) const override { return occluded(ray); }
  RayStructureStats stats() const override { return inner_.stats(); }

 private:
  const RayQuery& inner_;
  const std::unordered_set<std::uint64_t>* camera_ = nullptr;
  std::vector<Ray>*primary_ = nullptr, *others_ = nullptr, *shadow_ = nullptr;
};

// Makes the camera rays of iteration 0 again, by the same sampler, pixel by pixel.
std::unordered_set<std::uint64_t> camera_rays(const RenderContext& context) {
  std::unordered_set<std::uint64_t> hashes;
  for_pixels({ivec2(0), context.resolution}, [&](ivec2 pixel) {
    Sampler sampler(SamplerKind::sobol, context.seed, Stream::camera, pixel_index(pixel, context.resolution), 0);
    hashes.insert(hash_of(sample_camera_ray(context, pixel, sampler)));
  });
  return hashes;
}

std::unique_ptr<Integrator> make_integrator(const std::string& name, ParamMap params) {
  params["sampler"] = {std::string("sobol"), {}};
  return find_integrator(name, {}).make(params);
}

void record_path(const Scene& scene, const RayQuery& tracer, int resolution, RaysByKind& rays) {
  RecordingQuery recorder(tracer);
  Stage stage(scene, recorder, ivec2(resolution), 1);
  Film film(stage.context().resolution);
  const auto camera = camera_rays(stage.context());
  recorder.record(&camera, &rays[index_of(RayKind::primary)], &rays[index_of(RayKind::diffuse)],
                  &rays[index_of(RayKind::shadow)]);
  const auto path = make_integrator("path", {{"max_depth", {path_events, {}}}, {"mis", {std::string("power"), {}}}});
  path->prepare(stage.context());
  path->iteration(stage.context(), 0, film);
}

// While the map is prepared, photons fly; of what the gathering then asks, all but the camera's rays are gather rays (with, in
// scenes of mirrors and glass, what a camera ray becomes there).
void record_photon_map(const Scene& scene, const RayQuery& tracer, int resolution, RaysByKind& rays) {
  RecordingQuery recorder(tracer);
  Stage stage(scene, recorder, ivec2(std::max(1, resolution / gather_side)), 1);
  Film film(stage.context().resolution);
  const auto photons = static_cast<std::int64_t>(resolution) * resolution;
  const auto camera = camera_rays(stage.context());
  // Few neighbours, for the photons' density is of no interest here.
  const auto map = make_integrator("photon-map", {{"photons", {photons, {}}},
                                                  {"caustic_photons", {std::int64_t{1}, {}}},
                                                  {"k", {std::int64_t{2}, {}}},
                                                  {"final_gather", {gather_rays, {}}},
                                                  {"further_paths", {0.0, {}}},
                                                  {"max_depth", {path_events, {}}}});
  // The rays by which samples of direct light are chosen come before the photons'.
  std::vector<Ray> looks, &photon_rays = rays[index_of(RayKind::photon)];
  recorder.record(nullptr, nullptr, &looks, nullptr);
  choose_direct(stage.context());
  recorder.record(nullptr, nullptr, &photon_rays, nullptr);
  map->prepare(stage.context());
  photon_rays.erase(photon_rays.begin(), photon_rays.begin() + static_cast<std::ptrdiff_t>(looks.size()));
  recorder.record(&camera, nullptr, &rays[index_of(RayKind::gather)], nullptr);
  map->iteration(stage.context(), 0, film);
}

// --- how long they take ---

template <class Trace>
double rate(std::size_t rays, const Trace& trace) {
  if (rays == 0) return 0;
  return 1e-6 * static_cast<double>(rays) / std::max(1e-9, seconds_of(trace));
}

void trace_singly(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, std::vector<Hit>& hits) {
  hits.resize(rays.size());
  if (kind == RayKind::shadow) {
    std::size_t occluded = 0;
    for (const Ray& ray : rays) occluded += structure.occluded(ray);
    keep_answer(occluded);
  } else {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = structure.closest(rays[i]);
    keep_answer(hits.data());
  }
}

}  // namespace

const char* ray_kind_name(RayKind kind) {
  static constexpr const char* names[] = {"primary", "diffuse", "shadow", "photon", "gather"};
  return names[index_of(kind)];
}

std::vector<Ray> spread_runs(const std::vector<Ray>& rays, std::size_t count) {
  if (rays.size() <= count) return rays;
  const std::size_t runs = std::max<std::size_t>(1, count / run_length), length = std::min(count, run_length);
  std::vector<Ray> kept;
  for (std::size_t run = 0; run < runs; ++run) {
    const auto begin =
        rays.begin() + static_cast<std::ptrdiff_t>(run * (rays.size() - length) / std::max<std::size_t>(1, runs - 1));
    kept.insert(kept.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
  }
  return kept;
}

RaysByKind record_rays(const Scene& scene, const RayQuery& tracer, int resolution) {
  std::optional<Scene> lit;
  if (scene.lights.empty()) {
    lit = scene;
    lit->lights.emplace_back(EnvironmentLight{.scale = Rgb(1), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  }
  RaysByKind rays;
  with_threads(1, [&] {
    record_path(lit ? *lit : scene, tracer, resolution, rays);
    record_photon_map(lit ? *lit : scene, tracer, resolution, rays);
  });
  for (std::vector<Ray>& kind : rays) kind = spread_runs(kind, static_cast<std::size_t>(resolution) * resolution);
  return rays;
}

double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] { trace_singly(structure, kind, rays, hits); });
}

double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  if (kind == RayKind::shadow) {
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]());
    return rate(rays.size(), [&] {
      structure.occluded(rays, std::span(occluded.get(), rays.size()));
      keep_answer(occluded.get());
    });
  }
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] {
    structure.closest(rays, hits);
    keep_answer(hits.data());
  });
}

std::size_t affordable_rays(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, double seconds) {
  constexpr double enough = 2e-3;  // seconds that make a trial
  std::vector<Hit> hits;
  for (std::size_t trial = 4; trial < rays.size(); trial *= 4) {
    double time = infinity;  // the least of three: a pause of the machine is not the structure's
    for (int i = 0; i < 3 && time >= enough; ++i)
      time = std::min(time, seconds_of([&] { trace_singly(structure, kind, rays.first(trial), hits); }));
    if (time < enough) continue;
    return std::min(rays.size(), static_cast<std::size_t>(seconds / time * static_cast<double>(trial)));
  }
  return rays.size();
}

double mean_over_kinds(const ByRayKind<std::uint64_t>& counted, const ByRayKind<std::size_t>& traced, const RaysByKind& rays) {
  double sum = 0, weight = 0;
  for (std::size_t k = 0; k < ray_kinds.size(); ++k) {
    if (traced[k] == 0) continue;
    const auto own = static_cast<double>(rays[k].size());
    sum += own / static_cast<double>(traced[k]) * static_cast<double>(counted[k]);
    weight += own;
  }
  return weight > 0 ? sum / weight : 0;
}

Ray cosine_bounce(const Scene& scene, const Ray& ray, const Hit& hit, Sampler& sampler) {
  const SurfacePoint point = scene.surface_at(ray, hit);
  const vec3 normal = glm::dot(ray.direction, point.normal) > 0 ? -point.normal : point.normal;
  return {.origin = ray_origin(point, normal),
          .direction = Frame::from_normal(normal).to_world(sample_cosine_hemisphere(sampler.get_2d()))};
}

}  // namespace etendue
