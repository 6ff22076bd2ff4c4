// Shared by the progressive photon mappers: passes of new photons, each gathered at the points the camera sees.
//
// Iteration i traces a camera path per pixel, past specular-like vertices, to its rough vertices
// (integrators/photons/photon_camera_path.h), and a pass of photons. At each rough vertex it takes
//
//   direct              next-event estimation, one light sample (direct = "sample"), or photons
//   caustic, indirect   the pass's photons within the radius r_i that the method's policy gives (radius_policy.h)
//
// and emission as the camera path meets it: the same partition of paths as integrators/photons/photon_map.h, with one map for
// caustic and indirect photons. Emission and direct light take further camera paths where they scatter more than photons do
// (integrators/photons/direct_shares.h). The image is the mean over the iterations, the photons' part divided by the share of
// the kernels' discs that surface covers (integrators/photons/disc_coverage.h; edges = "disc": by the whole discs, as
// published). Sampling the direct light is the default since photons are worst at it: a pass gives its n photons per kernel,
// relative variance 4 / (3 n) and a blurred shadow, where one shadow ray gives a sharp one with a fraction of the variance, and
// the photons that remain are fewer and smoother ([Jensen2001] divides the light so).
//
// Photons are gathered at rough vertices and, with lobe tails = "gathered" where the camera path follows narrow rough lobes, in
// their lobe tails (integrators/photons/photons.h), which have a radius of their own per pixel. That is the default of cppm.
//
// r_1 comes from a pilot pass: per pixel, the distance to the `neighbours`-th photon about the point seen, or about one that
// lies within a fifth of that distance from it, at most twice the median of all pixels and 5 % of the scene's diagonal; in lobe
// tails to the fourth part of that, since they are a part of what is reflected. It is independent of the photons that are
// gathered, and so adds no bias of its own. Photons that a wall hides from the point do not count
// (integrators/photons/wall_grid.h), nor does the part of the disc behind it. Photons are emitted by power, or where they will
// be seen (integrators/photons/photons.h); the region seen is found once, by two paths per pixel.
//
// By default a pass has about as many photons as pixels: tracing and gathering them then take about as long as the camera
// paths, and noise that does not come from photons (edges, reflections in glass) falls as fast as theirs. `photons_per_pixel`
// = 0 depends on the scene: where light reaches no specular surface a pass has more. `neighbours` = 0 depends on the pilot
// pass: where its photons lie evenly about what is seen, kernels are wider.
//
// It is consistent as long as the policy's radius vanishes. At finite radii there is blur and, with edges = "disc", loss within
// r of edges (half of the photons' share at the edge itself).
#pragma once

#include "framework/core/parallel.h"
#include "framework/structure_names.h"
#include "integrators/paths/path.h"
#include "integrators/paths/wavefront.h"
#include "integrators/photons/direct_shares.h"
#include "integrators/photons/disc_coverage.h"
#include "integrators/photons/emission/visible_region.h"
#include "integrators/progressive/radius_policy.h"

#include <array>
#include <atomic>
#include <functional>
#include <numeric>

namespace etendue {

enum class DirectLighting : std::uint8_t { sample, photons };
constexpr auto names_of(DirectLighting) { return std::array{"sample", "photons"}; }

enum class DiscEdges : std::uint8_t { measured, disc };
constexpr auto names_of(DiscEdges) { return std::array{"measured", "disc"}; }

struct ProgressiveParams {
  int photons = 0;
  float photons_per_pixel = 1;
  int neighbours = 20;
  float radius = 0;
  DirectLighting direct = DirectLighting::sample;
  Kernel kernel = Kernel::epanechnikov;
  PhotonEmission emission = PhotonEmission::power;
  float carry_below = 0.25f;
  LobeTails lobe_tails = LobeTails::followed;
  bool side_test = true;
  DiscEdges edges = DiscEdges::measured;
  float further_paths = 2;
  int max_depth = 0;
  std::string structure = "hash-grid";
  SamplerKind sampler = SamplerKind::sobol;
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe_progressive(Visitor& v, ProgressiveParams& p) {
  v.integer("photons", p.photons, 0, 2000000000, "photons", "emitted per iteration; 0: by photons_per_pixel, at least 20000");
  v.number("photons_per_pixel", p.photons_per_pixel, 0, 1000, "photons",
           "of the image, emitted per iteration where photons = 0; 0: 1 where light reaches a specular surface, else 2.5");
  v.integer("neighbours", p.neighbours, 0, 1000000, "photons",
            "of one iteration within the first radius; 0: 50 where a pilot finds photons even over that many, else 20");
  v.number("radius", p.radius, 0, 1e12, "m", "first radius of every pixel; 0: from the density of the photons");
  v.choice("direct", p.direct, "direct light by sampling lights, or by photons like all else");
  v.choice("kernel", p.kernel, "density kernel, normalised");
  v.choice("emission", p.emission,
           "of photons: by the lights' power, more of it where photons will be seen, or by paths that are seen alone");
  describe_carry_below(v, p.carry_below);
  v.choice("lobe_tails", p.lobe_tails,
           "those lobes whole, or their core alone: in their tails photons are gathered, with less noise, but leaks under "
           "doors");
  v.flag("side_test", p.side_test, "refuse photons from another side of a wall or corner");
  v.choice("edges", p.edges,
           "photons are divided by what probes find of the kernel's disc over all passes, or by the whole disc");
  describe_further_paths(v, p.further_paths);
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("structure", p.structure, point_structure_names, "what finds the photons");
  v.choice("sampler", p.sampler, "random numbers");
  describe_lights(v, p.lights);
}

// Says which camera paths a pixel sees: a new one in every iteration, or the same `fixed` ones in turn.
struct VisiblePoints {
  std::uint32_t fixed = 0;

  std::uint32_t per_pixel() const { return std::max(fixed, 1u); }
  std::uint32_t path(std::uint32_t iteration) const { return fixed > 0 ? iteration % fixed : iteration; }
  // Index of the policy's state.
  std::size_t slot(std::size_t pixel, std::uint32_t iteration) const {
    return fixed > 0 ? pixel * fixed + iteration % fixed : pixel;
  }
};

// Photons, maps and camera paths: everything that does not depend on the radius.
class ProgressivePasses {
 public:
  ProgressivePasses(const ProgressiveParams& params, VisiblePoints points);

  void prepare(const RenderContext& context);
  // Walls count in gathers of this radius, and cost more in wider ones.
  void look_for_walls(const RenderContext& context, float radius);
  PhotonMap trace_map(const RenderContext& context, std::uint32_t pass) const;
  InitialRadii pilot(const RenderContext& context);

  // Radiance that arrives along the camera paths of a tile without photons, pixel by pixel as for_pixels has them; the paths
  // are traced together. at(pixel, GatherPoint, throughput, arrivals) at each rough vertex: what arrivals.gain(Arrival, way)
  // is given arrives before the paths go on, if its way is free. `lit`: else the vertices alone are wanted.
  template <class Arrival, class Gather>
  void camera(const RenderContext& context, const Tile& tile, std::uint32_t iteration, bool lit, std::vector<Rgb>& radiance,
              const Gather& at) const {
    struct View {
      ivec2 pixel;
      PathSample* sampled;  // its radiance, and the numbers of light samples
      Sampler path;
      PhotonCameraPath::State state;
    };
    static thread_local Wavefront<View, Arrival> wave;
    static thread_local std::vector<PathSample> paths, sampled;
    camera_paths(context, tile, params_.sampler, points_.path(iteration), paths);
    wave.clear();
    sampled.clear();
    for_pixels(tile, [&](ivec2 pixel) {
      const auto key = pixel_index(pixel, context.resolution);
      sampled.push_back({{}, {params_.sampler, context.seed, Stream::gather, key, iteration}});
    });
    std::size_t next = 0;
    for_pixels(tile, [&](ivec2 pixel) {
      wave.start({pixel, &sampled[next], paths[next].sampler, {}}, paths[next].ray);
      ++next;
    });
    const PhotonCameraPath walk{context, *rough_materials_, max_depth_};
    const auto share_of = [&](const View& view) { return direct_.share(pixel_index(view.pixel, context.resolution)); };
    wave.run(context, 0, [&](View& view, Ray& ray, const SurfacePoint* met, int so_far) {
      const bool goes_on = walk.meet(
          view.state, ray, met, so_far, view.path, view.sampled->sampler,
          [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth, float) {
            if (bsdf.is_diffuse() && is_black(bsdf.diffuse_albedo())) return;
            const bool samples_light = lit && params_.direct == DirectLighting::sample;
            if (samples_light && direct_.mode() == MisMode::power)
              view.sampled->radiance += share_of(view) * throughput *
                                        all_direct_light(context, point, bsdf, wo, view.sampled->sampler, MisMode::power);
            else if (samples_light)
              wave.light_samples().add(point, wo, share_of(view) * throughput, *view.sampled);
            const GatherPoint gathers(point, bsdf, wo, gathered_, max_depth_ - depth - 1);
            if (!gathers_behind_ || !bsdf.transmits()) return at(view.pixel, gathers, throughput, wave);
            for (const bool behind : {false, true}) at(view.pixel, gathers.of_side(behind), throughput, wave);
          },
          [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth) {
            const auto histories = static_cast<PhotonHistory>(gathered_ & ~photon_direct);
            at(view.pixel, GatherPoint(point, bsdf, wo, histories, max_depth_ - depth - 1, rough_materials_->tail_density()),
               throughput, wave);
          });
      if (!goes_on) view.sampled->radiance += share_of(view) * view.state.radiance;
      return goes_on;
    });
    radiance.clear();
    if (!lit) return;
    for_pixels(tile, [&](ivec2 pixel) {
      radiance.push_back(sampled[radiance.size()].radiance + direct_.further(walk, pixel, iteration));
    });
  }

  const VisiblePoints& points() const { return points_; }
  const RoughMaterials& rough_materials() const { return *rough_materials_; }
  // A pixel has one state of the policy for its rough vertices; another for lobe tails on the way there, where these are
  // gathered; and one, the last, for the far sides of vertices that let light through, where discs are measured: what is off
  // the surface may be another part on either side. (Tails of narrow lobes that let light through measure the seen side alone.)
  static constexpr std::uint32_t most_kinds = 3;
  std::uint32_t kinds() const { return 1 + gathers_tails_ + gathers_behind_; }
  std::size_t kind_of(const GatherPoint& at) const { return at.is_behind() ? kinds() - 1 : at.of_tails() ? 1 : 0; }
  std::size_t states(const RenderContext& context) const {
    return static_cast<std::size_t>(context.resolution.x) * context.resolution.y * points_.per_pixel() * kinds();
  }
  // The first of the `kinds` states of a pixel's point.
  std::size_t first_state(const RenderContext& context, ivec2 pixel, std::uint32_t iteration) const {
    return points_.slot(pixel_index(pixel, context.resolution), iteration) * kinds();
  }
  // The weight of a pixel's path in this iteration (pixel_filter.h).
  float weight(const RenderContext& context, ivec2 pixel, std::uint32_t iteration) const {
    return sample_weight(context, pixel, points_.path(iteration));
  }
  Kernel kernel() const { return params_.kernel; }
  LightChoice lights() const { return params_.lights; }
  // Null: photons are divided by whole discs.
  std::unique_ptr<DiscCoverage> make_coverage(const RenderContext& context) const;

 private:
  Photons trace(const RenderContext& context, std::uint64_t key) const;
  PhotonMap make_map(const RenderContext& context, Photons photons, const GatherOptions& options) const;
  PhotonMap pilot_map(const RenderContext& context, int neighbours);
  // Are the photons about what is seen so even that wide kernels smooth more than they blur?
  bool is_even(const RenderContext& context, const PhotonMap& map) const;

  ProgressiveParams params_;
  VisiblePoints points_;
  PhotonHistory gathered_;
  int max_depth_ = 0;
  std::unique_ptr<RoughMaterials> rough_materials_;
  bool gathers_tails_ = false, gathers_behind_ = false;
  float widest_ = infinity;              // radius
  std::unique_ptr<VisibleRegion> seen_;  // null where it is not needed
  std::shared_ptr<const WallGrid> walls_;
  DirectShares direct_;
};

// A method: the passes and its policy, made of the initial radii.
template <RadiusPolicy Policy>
class ProgressivePhotonMapping final : public Integrator {
 public:
  using MakePolicy = std::function<Policy(InitialRadii)>;

  ProgressivePhotonMapping(const ProgressiveParams& params, VisiblePoints points, MakePolicy make_policy, Expectation expected)
      : passes_(params, points), make_policy_(std::move(make_policy)), expected_(std::move(expected)) {}

  void prepare(RenderContext& context) override {
    context.choose_lights_by(passes_.lights());
    const auto timed = context.phases.measure("pilot");
    passes_.prepare(context);
    expected_ = expectation_in(context, passes_.rough_materials(), std::move(expected_));
    InitialRadii radii = passes_.pilot(context);
    if (!radii.empty()) widest_reach_ = *std::max_element(radii.begin(), radii.end());
    policy_ = std::make_unique<Policy>(make_policy_(std::move(radii)));
    coverage_ = passes_.make_coverage(context);
    if (coverage_) totals_.resize(passes_.states(context));
    if (coverage_ && has_signed_filter(context))
      weights_.resize(static_cast<std::size_t>(context.resolution.x) * context.resolution.y);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    passes_.look_for_walls(context, widest_reach_.exchange(0));
    const PhotonMap map = passes_.trace_map(context, index);
    const auto timed = context.phases.measure("gather");
    const std::uint32_t pass = index / per_pixel();
    if constexpr (requires { policy_->begin_pass(pass); }) policy_->begin_pass(pass);
    parallel_for(path_tile_count(context.resolution), 1,
                 [&](std::size_t number) { gather_tile(context, map, path_tile(context.resolution, number), index, film); });
  }

  Expectation expectation() const override { return expected_; }

 private:
  static constexpr std::uint32_t most_kinds = ProgressivePasses::most_kinds;

  struct Radiance {
    Rgb other{0};
    std::array<Rgb, most_kinds> from_photons{Rgb(0), Rgb(0), Rgb(0)};
  };
  // Over all passes of a state; `other` stands with the first one of a point.
  struct Totals {
    dvec3 other{0}, from_photons{0};
  };

  std::uint32_t per_pixel() const { return passes_.points().per_pixel(); }

  void add_up(const RenderContext& context, ivec2 pixel, std::uint32_t index, const Radiance& radiance) {
    const std::size_t mine = passes_.first_state(context, pixel, index);
    const double weight = passes_.weight(context, pixel, index);
    if (is_finite(radiance.other)) totals_[mine].other += weight * dvec3(radiance.other);
    for (std::uint32_t kind = 0; kind < passes_.kinds(); ++kind)
      if (is_finite(radiance.from_photons[kind]))
        totals_[mine + kind].from_photons += weight * dvec3(radiance.from_photons[kind]);
    if (!weights_.empty()) weights_[pixel_index(pixel, context.resolution)] += weight;
  }
  // Do photons bring so much of a point's light that what edges lose of it could be seen? `first`: of the point's states.
  bool shows_photons(std::size_t state, std::size_t first) const {
    constexpr double least_part = 0.01;
    const auto size = [](const dvec3& light) { return glm::dot(glm::abs(light), dvec3(1)); };
    const double photons = size(totals_[state].from_photons);
    return photons > 0 && photons >= least_part * size(totals_[first].other);
  }
  // The pixel after `index` + 1 iterations.
  dvec3 corrected(const RenderContext& context, ivec2 pixel, std::uint32_t index) const {
    dvec3 sum(0);
    const std::size_t first = passes_.first_state(context, pixel, 0);
    for (std::size_t s = first; s < first + per_pixel() * passes_.kinds(); ++s)
      sum += totals_[s].other + totals_[s].from_photons * coverage_->correction(s);
    if (weights_.empty()) return sum / (index + 1.0);
    const double weights = weights_[pixel_index(pixel, context.resolution)];
    return weights != 0 ? sum / weights : dvec3(0);
  }

  // A kernel's disc at one point, and what collects its photons.
  struct Disc {
    typename Policy::Observed observed;
    Rgb weight{0};  // of what a photon reflects
    float per_square = 0;
    Rgb radiance{0};
    bool gathers = false;

    void add(const GatheredPhoton& photon, Kernel kernel) {
      observed.add(photon.reflected, photon.offset, photon.distance_squared);
      const float x = photon.distance_squared * per_square;
      if (x <= 1) radiance += weight * photon.reflected * kernel_shape(kernel, x);
    }
  };
  using Discs = std::array<Disc, most_kinds>;  // of a pixel
  // A photon that counts if its way is free.
  struct Arrival {
    Disc* disc;
    Kernel kernel;
    GatheredPhoton photon;

    void arrive(const Ray& /*way*/) const { disc->add(photon, kernel); }
  };

  void gather_tile(const RenderContext& context, const PhotonMap& map, const Tile& tile, std::uint32_t index, Film& film) {
    static thread_local std::vector<Rgb> other;
    static thread_local std::vector<Discs> discs;
    static thread_local std::vector<DiscCoverage::Disc> gathered;
    const int width = tile.end.x - tile.begin.x;
    discs.assign(static_cast<std::size_t>(width) * (tile.end.y - tile.begin.y), {});
    gathered.clear();
    passes_.camera<Arrival>(
        context, tile, index, true, other, [&](ivec2 pixel, const GatherPoint& at, const Rgb& throughput, auto& arrivals) {
          const ivec2 place = pixel - tile.begin;
          const std::size_t kind = passes_.kind_of(at);
          const GatherSite site{context, passes_.first_state(context, pixel, index) + kind, index / per_pixel(), map, at};
          const float radius =
              gather(site, throughput, discs[static_cast<std::size_t>(place.y) * width + place.x][kind], arrivals);
          if (coverage_) gathered.push_back({site.pixel, pixel, at, radius, luminance(throughput * at.albedo())});
        });
    std::size_t place = 0;
    for_pixels(tile, [&](ivec2 pixel) {
      const Discs& of_pixel = discs[place];
      const Radiance radiance{other[place++], {of_pixel[0].radiance, of_pixel[1].radiance, of_pixel[2].radiance}};
      const std::size_t first = passes_.first_state(context, pixel, index);
      for (std::size_t kind = 0; kind < most_kinds; ++kind)
        if (of_pixel[kind].gathers) policy_->update(first + kind, index / per_pixel(), of_pixel[kind].observed);
      film.add(pixel, std::accumulate(radiance.from_photons.begin(), radiance.from_photons.end(), radiance.other), index,
               passes_.weight(context, pixel, index));
      if (coverage_) add_up(context, pixel, index, radiance);
    });
    if (!coverage_) return;
    std::erase_if(gathered, [&](const DiscCoverage::Disc& disc) {
      return !shows_photons(disc.slot, passes_.first_state(context, disc.pixel, index));
    });
    coverage_->measure(context, map, index, gathered);
    for_pixels(tile, [&](ivec2 pixel) { film.set(pixel, corrected(context, pixel, index)); });
  }

  // The radius of the kernel.
  template <class Arrivals>
  float gather(const GatherSite& site, const Rgb& throughput, Disc& disc, Arrivals& arrivals) {
    const GatherDisc size = policy_->disc(site);
    for (float widest = widest_reach_; widest < size.reach && !widest_reach_.compare_exchange_weak(widest, size.reach);)
      continue;
    const Kernel kernel = passes_.kernel();
    disc.per_square = 1 / square(size.radius);
    disc.weight = throughput * (inv_pi * disc.per_square);
    disc.gathers = true;
    disc.observed.begin(size, site.at, throughput);
    const float off_plane = coverage_ ? DiscCoverage::flatness * size.radius : infinity;
    site.map.gather(site.at, size.reach, off_plane, [&](const GatheredPhoton& photon, const std::optional<Ray>& way) {
      if (way && !site.context.needs.masks)
        arrivals.gain({&disc, kernel, photon}, *way);
      else if (!way || sees_landed(site.context, *way, site.at.position() + photon.offset))
        disc.add(photon, kernel);
    });
    return size.radius;
  }

  ProgressivePasses passes_;
  MakePolicy make_policy_;
  Expectation expected_;
  std::unique_ptr<Policy> policy_;
  std::unique_ptr<DiscCoverage> coverage_;  // null: whole discs
  std::vector<Totals> totals_;              // by slot; empty without coverage
  std::vector<double> weights_;             // of each pixel, summed up; empty where each is 1
  std::atomic<float> widest_reach_ = 0;     // of the last pass's gathers
};

}  // namespace etendue
