#include "integrators/photons/photon_maps.h"

#include "framework/core/elementary.h"
#include "framework/core/parallel.h"
#include "integrators/photons/cache_points.h"
#include "integrators/photons/kernel_domain.h"

namespace etendue {

namespace {

constexpr int fewest_photons = 200000;  // by default
constexpr float least_caustic_share = 0.1f;

// For a map that is new in every iteration. A kernel over k of them reaches over a small part of all there are.
int new_caustic_photons(ivec2 resolution, int k) {
  constexpr double a_pixel = 3, fewest = 20000, kernels = 800;
  return static_cast<int>(std::clamp(a_pixel * resolution.x * resolution.y, std::max(fewest, kernels * k), 2e9));
}

// The radius of a wide kernel, in metres, for maps that tell no radius.
float wide_radius(const Bounds& scene) {
  const float wide = 0.02f * glm::length(scene.diagonal());
  return std::isfinite(wide) && wide > 0 ? wide : 1;
}

}  // namespace

PhotonMaps::PhotonMaps(const PhotonMapsParams& params, const std::string& method) : params_(params) {
  if (params.k == 1) throw Error(method + ": k = 1: expected 0 (fixed radius) or at least 2");
}

void PhotonMaps::prepare(const RenderContext& context, const PhotonMapsUse& use) {
  if (params_.k == 0) check_given_radius(context, params_.radius);
  use_ = use;
  wide_radius_ = wide_radius(context.bounds);
  rough_materials_ =
      std::make_unique<RoughMaterials>(context.scene, params_.carry_below, LobeTails::followed, gathers_coats(context));
  const bool caustics = context.needs.caustic_map || rough_materials_->narrow_lobes();
  // A map that is seen directly shows caustics as well as one of their own does, in less time (experiments/ledger.toml).
  // But hulls are not for caustics, which are looked up apart where they have a map of their own, or gather rays the other.
  const bool hulls = params_.edges == Edges::hull;
  const bool needed = caustics && (use.gather_rays > 0 || use.interpolated || params_.caustic_photons > 0 || hulls);
  separate_caustics_ = params_.caustic_map == CausticMap::on || (params_.caustic_map == CausticMap::where_needed && needed);
  caustic_photons_ = params_.caustic_photons > 0 ? params_.caustic_photons
                     : use.new_caustics          ? new_caustic_photons(context.resolution, params_.k)
                                                 : fewest_photons;
  photons_ = params_.photons;
  if (photons_ == 0) photons_ = use.gather_rays > 0 ? enough_photons(context) : fewest_photons;
  holds_caustics_ = caustics && !separate_caustics_;
  global_edges_ = holds_caustics_ && hulls && use.gather_rays == 0 ? Edges::disc : params_.edges;
  global_seen_ = separate_caustics_ ? photon_indirect : photon_indirect | photon_caustic;
  if (params_.emission != PhotonEmission::power) mark_seen(context);
}

// As many as make the kernel's radius over k of them 0.7 % of the scene's diagonal, at the median of what pixels see; but not
// so many that a small image waits for its map. Where caustics are nowhere a tenth of the light that is seen, they need no map
// of their own, unless its photons are given.
int PhotonMaps::enough_photons(const RenderContext& context) {
  constexpr int pilots = 40000, near = 10, lines = 32;
  const auto timed = context.phases.measure("pilot");
  PhotonPass pass = pass_of(pilots, hash_keys(2), use_.max_depth - 1, photon_any, nullptr);
  pass.emission = PhotonEmission::power;
  build(context, global_, trace(context, pass), Edges::disc, params_.radius);
  constexpr float in_the_end = 0.007f, at_first = 0.03f;  // radii, over the diagonal of the scene, and of what is seen of it
  const float wanted = in_the_end * glm::length(context.bounds.diagonal());
  if (!(wanted > 0)) return fewest_photons;
  const double k = params_.k > 0 ? params_.k : 50, pixels = static_cast<double>(context.resolution.x) * context.resolution.y;
  const double most = std::clamp<double>(32 * pixels, fewest_photons, 10 * fewest_photons);
  const auto photons_for = [&](float radius) { return pilots * k / near * square(radius / wanted); };
  // From here on `most` photons are wanted at first.
  const float widest = 1.01f * at_first / in_the_end * wanted * static_cast<float>(std::sqrt(most / photons_for(wanted)));
  const bool asks_for_caustics =
      separate_caustics_ && params_.caustic_map == CausticMap::where_needed && params_.caustic_photons == 0;
  std::vector<float> radii(lines * lines), shares(lines * lines);
  std::vector<Bounds> boxes(lines * lines);
  parallel_for(radii.size(), 16, [&](std::size_t i) {
    const ivec2 pixel = ivec2(i % lines, i / lines) * context.resolution / lines;
    const CachePoint seen = find_cache_point(context, pixel, use_.max_depth, use_.sampler, rough_materials_.get());
    if (seen) {
      boxes[i].extend(seen.position);
      radii[i] =
          global_.distance_to(context, near, GatherPoint::irradiance(seen.position, seen.geometric, seen.origin), widest);
    }
    if (!asks_for_caustics || (i + 2 * (i / lines)) % 4 != 0) return;  // a quarter, staggered: look-ups take time
    const CachePoint rough = find_rough_point(context, pixel, use_.max_depth, use_.sampler, *rough_materials_);
    if (!rough) return;
    const auto light_of = [&](PhotonHistory histories) {
      return luminance(global_.estimate(
          context, GatherPoint::irradiance(rough.position, rough.geometric, rough.origin, use_.max_depth, histories)));
    };
    if (const float caustics = light_of(photon_caustic); caustics > 0) shares[i] = caustics / light_of(photon_any);
  });
  if (asks_for_caustics && *std::ranges::max_element(shares) < least_caustic_share) separate_caustics_ = false;
  if (params_.emission == PhotonEmission::power) pilots_ = pilots;
  global_.set_edges(params_.edges);  // the pilot asks without, as hulls of caustics mislead
  std::erase(radii, 0.0f);
  if (radii.empty()) return fewest_photons;
  const double photons = photons_for(median(radii));
  Bounds seen;
  for (const Bounds& box : boxes) seen.extend(box);
  first_photons_ = static_cast<int>(std::min(most, photons * square(wanted / (at_first * glm::length(seen.diagonal())))));
  return static_cast<int>(std::clamp<double>(photons, fewest_photons, most));
}

void PhotonMaps::mark_seen(const RenderContext& context) {
  const auto timed = context.phases.measure("initial_pass");
  const SeenOptions options{4, use_.max_depth, use_.sampler, params_.side_test};
  // Twice what k photons need of the area seen if half of those emitted reach it, as densities differ; for gather rays, a
  // fiftieth of the scene.
  const double area = seen_area(context, *rough_materials_, options);
  const double photons = 0.5 * std::min(photons_, separate_caustics_ ? caustic_photons_ : photons_);
  const double needed = 2 * std::sqrt((params_.k > 0 ? params_.k : 50) * area / (std::numbers::pi * photons));
  const bool gathers = use_.gather_rays > 0;
  const float reach = params_.radius > 0 ? params_.radius
                      : gathers          ? wide_radius_
                                         : std::clamp(static_cast<float>(needed), 1e-3f * wide_radius_, wide_radius_);
  // Half as much again, for what lies between the samples of a pixel.
  seen_ = find_seen(context, *rough_materials_, options, 1.5f * reach);
  // Where the global map holds the caustics, these are looked up where the camera sees them.
  if (gathers)
    gathered_ = find_seen(context, *rough_materials_, options, 1.5f * reach, std::min(use_.gather_rays, 16), holds_caustics_);
  if (params_.emission == PhotonEmission::visibility) largest_radius_ = reach;  // beyond it there may be no photons
}

PhotonPass PhotonMaps::pass_of(int count, std::uint64_t key, int max_scatterings, PhotonHistory keep,
                               const VisibleRegion* visible) const {
  return {static_cast<std::uint32_t>(count), key, max_scatterings, keep, use_.sampler, params_.emission, visible};
}

Photons PhotonMaps::trace(const RenderContext& context, const PhotonPass& pass) const {
  const auto timed = context.phases.measure("emit");
  return trace_photons(context, *rough_materials_, pass);
}

void PhotonMaps::build(const RenderContext& context, PhotonMap& map, Photons photons, Edges edges, float radius, float share,
                       bool widen) {
  map.build(std::move(photons), context.make_points(params_.structure),
            {params_.k, radius, params_.kernel, params_.side_test, largest_radius_, edges, share, wide_radius_, widen});
  if (!params_.side_test) return;
  walls_ = wall_grid(context.scene, map.radius(), walls_);
  map.set_walls(walls_);
}

// The event at which a photon is gathered counts too, and so does the one at the visible point before a gather ray.
void PhotonMaps::trace_global(RenderContext& context, std::uint32_t pass, float share) {
  const bool gathers = use_.gather_rays > 0;
  const int photons_wanted = std::max(1, static_cast<int>(static_cast<double>(share) * photons_));
  const auto pass_for = [&](int count, std::uint64_t key) {
    return pass_of(count, key, use_.max_depth - (gathers && !holds_caustics_ ? 2 : 1), gathers ? photon_any : global_seen_,
                   gathered_ ? gathered_.get() : seen_.get());
  };
  if (photons_wanted <= pilots_) {
    if (!irradiance_) precompute(context, pass_for(pilots_, hash_keys(2, 1)));
    return;
  }
  Photons photons = trace(context, pass_for(photons_wanted, hash_keys(0, pass)));
  pilots_ = 0;
  irradiance_.reset();
  {
    const auto timed = context.phases.measure("build");
    build(context, global_, std::move(photons), global_edges_, params_.radius);
  }
  if (gathers) precompute(context, pass_for(photons_wanted, hash_keys(0, pass, 1)));
}

void PhotonMaps::precompute(const RenderContext& context, PhotonPass pass) {
  if (params_.precompute == 0) return;
  pass.count = std::max(1u, pass.count / static_cast<std::uint32_t>(params_.precompute));
  Photons sample_points = trace(context, pass);
  if (context.needs.masks) {  // for what takes records alone
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < sample_points.size(); ++i)
      if (!lets_light_through(sample_points.side[i].layer)) kept.push_back(i);
    sample_points = reordered(std::move(sample_points), kept);
  }
  const auto timed = context.phases.measure("build");
  irradiance_ = std::make_unique<PhotonIrradiance>(global_, sample_points, context.make_points(params_.structure));
}

// How far from photons the nearest fifth of those of earlier iterations is, in the median: one photon alone tells nothing of
// how wide the caustic is that it is part of, and a few that belong to several tell of the way between them. 0: not known.
float PhotonMaps::radius_of_few(const std::vector<vec3>& positions) {
  constexpr std::size_t most = 256;
  std::vector<float> distances, to_earlier;
  for (const vec3& p : positions) {
    if (earlier_.empty()) break;
    to_earlier.clear();
    for (const vec3& q : earlier_) to_earlier.push_back(glm::length(p - q));
    const auto fifth = to_earlier.begin() + static_cast<std::ptrdiff_t>((to_earlier.size() - 1) / 5);
    std::nth_element(to_earlier.begin(), fifth, to_earlier.end());
    distances.push_back(*fifth);
  }
  earlier_.insert(earlier_.end(), positions.begin(), positions.end());
  if (earlier_.size() > most) earlier_.erase(earlier_.begin(), earlier_.end() - most);
  return distances.empty() ? 0 : median(distances);
}

void PhotonMaps::trace_caustics(RenderContext& context, std::uint32_t pass) {
  if (!separate_caustics_) return;
  Photons photons =
      trace(context, pass_of(caustic_photons_, hash_keys(1, pass), use_.max_depth - 1, photon_caustic, seen_.get()));
  const auto timed = context.phases.measure("build");
  const bool few = use_.new_caustics && params_.radius == 0 && photons.size() < static_cast<std::size_t>(params_.k);
  const float radius = few ? std::min({radius_of_few(photons.position), wide_radius_, largest_radius_}) : params_.radius;
  const float share = use_.new_caustics ? static_cast<float>(1 / math::cbrt(pass + 1.0)) : 1;
  // What kernels lose at edges they would lose in every iteration, and their ends are soon found.
  const Edges edges = use_.new_caustics ? Edges::visible : params_.edges;
  build(context, caustic_, std::move(photons), edges, radius, share, use_.new_caustics);
}

Rgb PhotonMaps::caustics(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                         int max_scatterings, float tail_density) const {
  if (separate_caustics_) return caustic_.radiance(context, point, bsdf, wo, photon_caustic, max_scatterings, tail_density);
  if (use_.gather_rays == 0) return Rgb(0);
  return global_.radiance(context, point, bsdf, wo, photon_caustic, max_scatterings, tail_density);
}

}  // namespace etendue
