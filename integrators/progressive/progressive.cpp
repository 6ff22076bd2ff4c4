#include "integrators/progressive/progressive.h"

#include "integrators/photons/cache_points.h"
#include "integrators/photons/kernel_domain.h"

#include <numeric>

namespace etendue {

namespace {

struct NoArrival {
  void arrive(const Ray& /*way*/) const {}
};

// Distances to the k-th nearest photon, of the points that a tile sees. Two points' distances differ by no more than the points
// lie apart, where the same photons count. So a point takes the distance of one on its side that is nearer than a fifth of it.
// Where few photons count, distances are long and take the longest to find, and many points share one.
class KnownRadii {
 public:
  KnownRadii(const PhotonMap& map, int k, float widest) : map_(map), k_(k), widest_(widest) {}

  float operator()(const RenderContext& context, const GatherPoint& at) {
    constexpr float share = 0.2f, same_side = 0.9f;
    for (const Known& known : known_)
      if (length_squared(at.position() - known.position) < square(share * known.radius) &&
          glm::dot(at.normal(), known.normal) > same_side)
        return known.radius;
    const float guess = known_.empty() ? 0 : 1.15f * known_.back().radius;
    known_.push_back({at.position(), at.normal(), map_.distance_to(context, k_, at, widest_, guess)});
    return known_.back().radius;
  }

 private:
  struct Known {
    vec3 position, normal;
    float radius;
  };

  const PhotonMap& map_;
  int k_;
  float widest_;
  std::vector<Known> known_;
};

constexpr std::uint64_t pilot_key = 0xffffffffffffffffull;
constexpr int few_neighbours = 20, many_neighbours = 50;  // of which the pilot chooses

}  // namespace

ProgressivePasses::ProgressivePasses(const ProgressiveParams& params, VisiblePoints points)
    : params_(params),
      points_(points),
      gathered_(params.direct == DirectLighting::sample ? photon_caustic | photon_indirect : photon_any) {}

void ProgressivePasses::prepare(const RenderContext& context) {
  check_given_radius(context, params_.radius);
  max_depth_ = context.max_depth(params_.max_depth);
  rough_materials_ =
      std::make_unique<RoughMaterials>(context.scene, params_.carry_below, params_.lobe_tails, gathers_coats(context));
  gathers_tails_ = rough_materials_->narrow_lobes() && params_.lobe_tails == LobeTails::gathered;
  for (std::uint32_t m = 0; m < context.scene.materials.size(); ++m)
    gathers_behind_ |= params_.edges != DiscEdges::disc && params_.side_test && (*rough_materials_)(m) &&
                       transmits(context.scene.materials[m]);
  const bool caustics = context.needs.caustic_map;
  if (params_.photons_per_pixel == 0) params_.photons_per_pixel = caustics ? 1 : 2.5f;
  if (params_.photons == 0) {
    const double wanted = static_cast<double>(params_.photons_per_pixel) * context.resolution.x * context.resolution.y;
    params_.photons = static_cast<int>(std::clamp(std::round(wanted), 2e4, 2e9));
  }
  direct_ = {{context, *rough_materials_, max_depth_},
             params_.sampler,
             params_.further_paths,
             params_.direct == DirectLighting::sample};
  if (params_.emission == PhotonEmission::power && params_.radius > 0) return;
  widest_ = params_.radius > 0 ? params_.radius : 0.05f * glm::length(context.bounds.diagonal());
  // Half as much again as the radius, for what lies between the samples of a pixel.
  seen_ = find_seen(context, *rough_materials_, {2, max_depth_, params_.sampler, params_.side_test}, 1.5f * widest_);
}

void ProgressivePasses::look_for_walls(const RenderContext& context, float radius) {
  if (params_.side_test && radius > 0) walls_ = wall_grid(context.scene, radius, walls_);
}

PhotonMap ProgressivePasses::trace_map(const RenderContext& context, std::uint32_t pass) const {
  return make_map(context, trace(context, pass), {0, 1, params_.kernel, params_.side_test});
}

Photons ProgressivePasses::trace(const RenderContext& context, std::uint64_t key) const {
  const auto timed = context.phases.measure("emit");
  // The event at which a photon is gathered counts too.
  return trace_photons(context, *rough_materials_,
                       {static_cast<std::uint32_t>(params_.photons), key, max_depth_ - 1, gathered_, params_.sampler,
                        params_.emission, params_.emission == PhotonEmission::power ? nullptr : seen_.get()});
}

PhotonMap ProgressivePasses::make_map(const RenderContext& context, Photons photons, const GatherOptions& options) const {
  const auto timed = context.phases.measure("build");
  PhotonMap map;
  map.build(std::move(photons), context.make_points(params_.structure), options);
  if (params_.side_test) map.set_walls(walls_);
  return map;
}

// Photons that nobody sees are left out: behind a thin wall they may be many times as dense as before it.
PhotonMap ProgressivePasses::pilot_map(const RenderContext& context, int neighbours) {
  Photons photons = trace(context, pilot_key);
  std::vector<std::uint32_t> seen;
  for (std::uint32_t i = 0; i < photons.size(); ++i)
    if (seen_->contains(photons.position[i], photons.side[i].normal())) seen.push_back(i);
  PhotonMap map = make_map(context, reordered(std::move(photons), seen), {neighbours, 0, params_.kernel, params_.side_test});
  look_for_walls(context, map.radius());
  if (params_.side_test) map.set_walls(walls_);
  return map;
}

std::unique_ptr<DiscCoverage> ProgressivePasses::make_coverage(const RenderContext& context) const {
  if (params_.edges == DiscEdges::disc) return nullptr;
  return std::make_unique<DiscCoverage>(*rough_materials_,
                                        DiscCoverage::Rules{params_.kernel, params_.side_test, params_.sampler},
                                        context.resolution, states(context));
}

// In even light the square of the distance of the 20th photon over that of the 50th has the mean 0.4 and the variance 0.4 (1 -
// 0.4) / 51, and it differs from 0.4 in proportion to the light's curvature, that is to the blur of kernels. Where fewer
// photons are near, as in shadows, the 10th of 25 tells.
bool ProgressivePasses::is_even(const RenderContext& context, const PhotonMap& map) const {
  constexpr int lines = 32;
  constexpr float share = static_cast<float>(few_neighbours) / many_neighbours;
  constexpr float most = 1.27f;
  std::vector<float> deviations(lines * lines, -1);
  parallel_for(deviations.size(), 16, [&](std::size_t i) {
    const ivec2 pixel = ivec2(i % lines, i / lines) * context.resolution / lines;
    const CachePoint seen = find_rough_point(context, pixel, max_depth_, params_.sampler, *rough_materials_);
    if (!seen) return;
    const GatherPoint at = GatherPoint::irradiance(seen.position, seen.geometric, seen.origin);
    for (const int far : {many_neighbours, many_neighbours / 2}) {
      const float radius = map.distance_to(context, far, at, widest_);
      if (!(radius < widest_)) continue;
      const float inner = map.distance_to(context, far * few_neighbours / many_neighbours, at, radius) / radius;
      deviations[i] = square(square(inner) - share) * static_cast<float>(far + 1) / (share * (1 - share));
      break;
    }
  });
  std::erase(deviations, -1.0f);
  const float mean = std::accumulate(deviations.begin(), deviations.end(), 0.0f) / static_cast<float>(deviations.size());
  return deviations.empty() || mean <= most;
}

InitialRadii ProgressivePasses::pilot(const RenderContext& context) {
  if (params_.radius > 0) return InitialRadii(states(context), params_.radius);
  const PhotonMap map = pilot_map(context, params_.neighbours > 0 ? params_.neighbours : many_neighbours);
  const int neighbours = params_.neighbours > 0 ? params_.neighbours : is_even(context, map) ? many_neighbours : few_neighbours;
  InitialRadii radii(states(context), 0);
  parallel_for(path_tile_count(context.resolution), 1, [&](std::size_t number) {
    std::vector<Rgb> unused;
    std::array<KnownRadii, 2> known{{{map, neighbours, widest_}, {map, std::max(1, neighbours / 4), widest_}}};  // of tails
    for (std::uint32_t i = 0; i < points_.per_pixel(); ++i)
      camera<NoArrival>(context, path_tile(context.resolution, number), i, false, unused,
                        [&](ivec2 pixel, const GatherPoint& at, const Rgb&, auto&) {
                          float& radius = radii[first_state(context, pixel, i) + kind_of(at)];
                          if (radius == 0) radius = known[at.of_tails()](context, at);
                        });
  });
  // Both sides of a sheet have one radius: where light falls on one alone, no photon tells the other's.
  for (std::size_t s = 0; gathers_behind_ && s < radii.size(); s += kinds())
    if (float& near = radii[s], &far = radii[s + kinds() - 1]; near > 0 && far > 0) near = far = std::min(near, far);
  for (std::size_t kind = 0; kind < kinds(); ++kind) {
    std::vector<float> known;
    for (std::size_t s = kind; s < radii.size(); s += kinds())
      if (radii[s] > 0) known.push_back(radii[s]);
    const float usual = known.empty() ? widest_ : median(known);
    for (std::size_t s = kind; s < radii.size(); s += kinds()) radii[s] = radii[s] > 0 ? std::min(radii[s], 2 * usual) : usual;
  }
  return radii;
}

}  // namespace etendue
