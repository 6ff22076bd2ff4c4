#include "integrators/bidirectional/vcm.h"

#include "framework/core/lists.h"
#include "framework/core/parallel.h"
#include "integrators/bidirectional/vcm_camera_paths.h"
#include "integrators/paths/path.h"
#include "integrators/photons/kernel_domain.h"
#include "integrators/photons/photon_maps.h"
#include "integrators/photons/photons.h"
#include "integrators/progressive/radius_policy.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace etendue {

namespace {

enum class Setting : std::uint8_t { light_trace, bdpt, vcm };

// Points a side of the grid at which the pilot pass looks for light vertices, and its number among the iterations.
constexpr int pilot_grid = 32;
constexpr std::uint32_t pilot_iteration = 0xffffffffu;

// A first radius that is not given is at most this, over the scene's diagonal: on open ground discs of any size are whole. It
// is halved while more than this share of the light lands on surfaces that are small for it, or more than that share of the
// points seen lie on such: light that lands about a room tells nothing of what is in it.
constexpr float largest_radius = 0.05f;
constexpr double most_on_small_surfaces = 0.02, most_seen_on_small_surfaces = 0.1;
constexpr int most_halvings = 10;
constexpr std::size_t discs_tried = 256;

// Roughness (GGX alpha) below which the lens hardly ever lies in the lobe of a surface that a light path meets.
constexpr float narrow_lobe = 0.05f;

// The middle of a disc of merges, and the side that is looked at. Its light is the power that lands there, and 1 of points
// seen.
struct MergeDisc {
  vec3 position, normal;
  double light = 1;
};

vec3 facing(const vec3& normal, const vec3& wo) { return glm::dot(normal, wo) < 0 ? -normal : normal; }

// At the first surface with a lobe to merge at that a camera ray meets, through delta lobes.
std::optional<MergeDisc> visible_disc(const RenderContext& context, ivec2 pixel) {
  const auto key = pixel_index(pixel, context.resolution);
  Sampler sampler(SamplerKind::independent, context.seed, Stream::initial_pass, key, 0);
  Ray ray = sample_camera_ray(context, pixel, sampler);
  for (int depth = 0; depth < 16; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) return std::nullopt;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const Bsdf bsdf(context.scene, point);
    if (bsdf.has_non_specular()) return MergeDisc{point.position, facing(point.normal, -ray.direction)};
    const float u_lobe = sampler.get_1d();
    const BsdfSample next = bsdf.sample(-ray.direction, u_lobe, sampler.get_2d());
    if (!next) return std::nullopt;
    ray = spawn_ray(point, next.wi);
  }
  return std::nullopt;
}

MergeDisc disc_of(const LightVertex* vertex) {
  return {vertex->point.position, facing(vertex->point.normal, vertex->wo), luminance(vertex->power)};
}

// The share of light whose discs lie on the surface with less than half of their area, as they do inside a smaller lamp. Merges
// divide what they find by all of the disc.
double share_on_small_surfaces(const RenderContext& context, std::span<const MergeDisc> discs, float radius) {
  const std::size_t tried = std::min(discs.size(), discs_tried);
  std::vector<std::uint8_t> small(tried);
  const auto disc = [&](std::size_t i) -> const MergeDisc& { return discs[i * discs.size() / tried]; };
  parallel_for(tried, 8, [&](std::size_t i) {
    small[i] = VisibleDomain(context, disc(i).position, disc(i).normal, radius).share(Kernel::box) < 0.5f;
  });
  double all = 0, on_small = 0;
  for (std::size_t i = 0; i < tried; ++i) {
    all += disc(i).light;
    if (small[i]) on_small += disc(i).light;
  }
  return all > 0 ? on_small / all : 0;
}

class Vcm final : public Integrator {
 public:
  Vcm(const VcmParams& params, Setting setting) : params_(params), setting_(setting) {
    settings_.connect = setting != Setting::light_trace;
    settings_.roulette_depth = params.roulette_depth;
    settings_.wall_test = params.wall_test;
    settings_.correlation = params.mis == VcmMis::correlation_aware;
    settings_.sampler = params.sampler;
  }

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;

 private:
  float first_radius(const RenderContext& context, int neighbours);

  VcmParams params_;
  Setting setting_;
  bool merges_vertices_ = false;
  VcmSettings settings_;
  float first_radius_ = 0;
  bool specular_ = false, narrow_lobes_ = false, caustics_ = false, hidden_caustics_ = false;
  LightPaths light_paths_;
  VcmMerges merges_;
  std::vector<dvec3> splats_;
  // Holds, where the filter is signed, what each pixel's camera paths see (weighted), their weights, and the splats.
  struct Signed {
    dvec3 seen{0}, splats{0};
    double weights = 0;
  };
  std::vector<Signed> signed_;
};

void Vcm::prepare(RenderContext& context) {
  if (settings_.connect) context.choose_lights_by(params_.lights);
  settings_.max_depth = context.max_depth(params_.max_depth);
  const auto pixels = static_cast<std::uint32_t>(context.resolution.x * context.resolution.y);
  settings_.paths = params_.paths > 0 ? static_cast<std::uint32_t>(params_.paths) : pixels;
  if (has_signed_filter(context)) signed_.assign(pixels, {});
  const Scene& scene = context.scene;
  specular_ = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return has_specular(m); });
  narrow_lobes_ = RoughMaterials(scene, narrow_lobe).narrow_lobes();
  caustics_ = context.needs.caustic_map;
  hidden_caustics_ = caustics_ && std::any_of(scene.lights.begin(), scene.lights.end(), is_delta);
  if (setting_ != Setting::vcm) return;
  const int neighbours = params_.neighbours > 0 ? params_.neighbours : neighbours_by_need(context);
  merges_vertices_ = params_.radius > 0 || neighbours > 0;
  settings_.correlation = settings_.correlation && merges_vertices_;
  check_given_radius(context, params_.radius);
  if (merges_vertices_) first_radius_ = params_.radius > 0 ? params_.radius : first_radius(context, neighbours);
}

float Vcm::first_radius(const RenderContext& context, int neighbours) {
  const auto timed = context.phases.measure("pilot");
  const ivec2 grid = glm::min(ivec2(pilot_grid), context.resolution);
  std::vector<std::optional<MergeDisc>> of_pixel(static_cast<std::size_t>(grid.x) * grid.y);
  parallel_pixels(grid, [&](ivec2 i) {
    of_pixel[static_cast<std::size_t>(i.y) * grid.x + i.x] =
        visible_disc(context, (2 * i + 1) * context.resolution / (2 * grid));
  });
  std::vector<MergeDisc> seen;
  for (const auto& disc : of_pixel)
    if (disc) seen.push_back(*disc);
  {
    const auto emitting = context.phases.measure("emit");
    light_paths_.trace(context, settings_, pilot_iteration, true);
  }
  const auto k = static_cast<std::size_t>(neighbours);
  const float usual =
      VcmMerges::usual_distance(context, light_paths_, mapped(seen, &MergeDisc::position), k, params_.structure);
  const float diagonal = glm::length(context.bounds.diagonal());
  if (!(usual > 0)) return 0.01f * diagonal;
  const std::vector<MergeDisc> lit = mapped(light_paths_.vertices(), disc_of);
  const float widest = std::min(usual, largest_radius * diagonal);
  const auto halved = [&](int times) { return std::ldexp(widest, -times); };
  std::array<std::optional<bool>, most_halvings + 4> known;
  const auto is_too_wide = [&](int times) {
    if (!known[times])
      known[times] = share_on_small_surfaces(context, lit, halved(times)) > most_on_small_surfaces ||
                     share_on_small_surfaces(context, seen, halved(times)) > most_seen_on_small_surfaces;
    return *known[times];
  };
  // A disc more than five times as wide as a table is high takes the plain below for the table. Two or three halvings on it no
  // longer does, and half of the disc is off the table, or it fits.
  int times = 0;
  while (times < most_halvings && (is_too_wide(times) || is_too_wide(times + 2) || is_too_wide(times + 3))) ++times;
  return halved(times);
}

void Vcm::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  if (merges_vertices_) settings_.merge_radius = first_radius_ * memoryless_shrinkage(index, params_.alpha);
  {
    const auto timed = context.phases.measure("emit");
    light_paths_.trace(context, settings_, index, settings_.connect);
    splats_.assign(static_cast<std::size_t>(context.resolution.x) * context.resolution.y, dvec3(0));
    light_paths_.add_splats(splats_);
  }
  if (merges_vertices_) {
    const auto timed = context.phases.measure("build");
    merges_.build(context, light_paths_, settings_, params_.structure);
  }
  const auto timed = context.phases.measure("trace");
  parallel_for(path_tile_count(context.resolution), 1, [&](std::size_t number) {
    const Tile tile = context.seen(path_tile(context.resolution, number));
    static thread_local std::vector<Rgb> radiance;
    radiance.assign(static_cast<std::size_t>(tile.end.x - tile.begin.x) * (tile.end.y - tile.begin.y), Rgb(0));
    VcmCameraPaths(context, settings_, light_paths_, merges_).trace(tile, index, radiance);
    auto value = radiance.begin();
    for_pixels(tile, [&](ivec2 pixel) {
      const std::size_t i = pixel_index(pixel, context.resolution);
      const Rgb seen = *value++, splats(splats_[i]);
      film.add(pixel, seen + splats, index);
      if (signed_.empty()) return;
      Signed& so_far = signed_[i];
      const double weight = sample_weight(context, pixel, index);
      if (is_finite(seen)) {
        so_far.seen += weight * dvec3(seen);
        so_far.weights += weight;
      }
      if (is_finite(splats)) so_far.splats += splats_[i];
      film.set(pixel, so_far.splats / (index + 1.0) + (so_far.weights != 0 ? so_far.seen / so_far.weights : dvec3(0)));
    });
  });
}

Expectation Vcm::expectation() const {
  if (merges_vertices_) {
    const double alpha = params_.alpha;
    return {alpha < 1 ? Bias::consistent : Bias::biased, progressive_exponent(alpha), 0.02,
            "blur within the merging radius, which shrinks ([Knaus2011]); paths that need no merging converge as N^-1"};
  }
  if (setting_ == Setting::light_trace && specular_)
    return {Bias::biased, -1, 1,
            "specular surfaces are black: the method cannot sample paths that end on one before the camera",
            fmt::format("specular surfaces are black, and so is what is seen by way of them; {} brings it",
                        caustics_ ? "vcm" : "bdpt")};
  if (setting_ == Setting::light_trace && narrow_lobes_)
    return {Bias::unbiased, -1, 0, "",
            "surfaces of narrow lobes, such as frosted glass of an index near 1, are noise or black, and so is what is seen by "
            "way of them; bdpt brings it"};
  if (setting_ == Setting::bdpt && hidden_caustics_)
    return {Bias::biased, -1, 1, "caustics of point, spot and directional lights are black where specular surfaces show them",
            "light from delta lights that comes by way of specular surfaces is left out where they show it; vcm "
            "brings it"};
  return {Bias::unbiased, -1, 0, ""};
}

template <class Params>
IntegratorEntry entry(const char* name, const char* summary, Setting setting, double bytes_a_pixel) {
  const auto make = [setting](const Params& given) {
    VcmParams params;
    static_cast<Params&>(params) = given;
    return std::make_unique<Vcm>(params, setting);
  };
  return integrator_entry<Params>(name, summary, make, bytes_a_pixel);
}

}  // namespace

int neighbours_by_need(const RenderContext& context) {
  constexpr std::size_t many_lamps = 128;  // at about 100 merges and connections cost the same for the same error
  constexpr double far_apart = 0.1;        // of the scene's radius
  if (context.needs.caustic_map) return 4;
  if (context.lights.lamps() >= many_lamps && context.lights.spread() > far_apart) return 4;
  const float narrow = PhotonMapsParams().carry_below;
  return context.lights.any_delta() && RoughMaterials(context.scene, narrow).narrow_lobes() ? 1 : 0;
}

IntegratorEntry light_trace_entry() {
  return entry<LightTraceParams>("light-trace", "particles from the lights joined to the camera", Setting::light_trace, 230);
}

IntegratorEntry bdpt_entry() {
  return entry<BdptParams>("bdpt", "bidirectional path tracing: all ways to join paths from the camera and from the lights",
                           Setting::bdpt, 760);
}

IntegratorEntry vcm_entry() {
  return entry<VcmParams>("vcm",
                          "vertex connection and merging: bidirectional path tracing and photon mapping, weighed together",
                          Setting::vcm, 1050);
}

}  // namespace etendue
