// Unidirectional path tracing with next-event estimation and multiple importance sampling ([Kajiya1986], [Veach1995]).
//
// Unbiased up to the depth limit. Depth counts scattering events on the whole path; Russian roulette begins at `roulette_depth`
// and survives with the largest component of the throughput, or more where paths scatter little (path_choices.h). The paths of
// a tile advance together, event by event, so that the ray structure gets many rays at once; the image has the same bits as if
// each path were traced alone.
#pragma once

#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "framework/integrator.h"
#include "framework/transport/direct_light.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace etendue {

struct PathParams {
  int max_depth = 0;
  int roulette_depth = 5;
  std::string mis = "auto";
  std::string sampler = "sobol";
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe(Visitor& v, PathParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.choice(
      "mis", p.mis, {"auto", "power", "balance", "light", "bsdf"},
      "how light and BSDF sampling share the work; auto: by the power heuristic, or one alone where the other adds nothing");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
  describe_lights(v, p.lights);
}

SamplerKind parse_sampler(const std::string& name);  // of a checked parameter

struct PathSettings {
  int max_depth = 64;
  int roulette_depth = 5;
  MisMode mis = MisMode::power;
  float evenness = 1;  // as survival_of (roulette.h)
};

// Paths of a pixel from this number on are no image's: looks at a scene take them.
inline constexpr std::uint32_t no_images_path = 1u << 30;
// Number i of side x side pixels that lie evenly over the image.
inline ivec2 grid_pixel(ivec2 resolution, int side, int i) {
  return (2 * ivec2(i % side, i / side) + 1) * resolution / (2 * side);
}

// A path: its first ray, its random numbers, and the result.
struct PathSample {
  Ray ray;
  Sampler sampler;
  Rgb radiance{0};                   // arriving along the ray
  float first_distance = infinity;   // to the first hit, in lengths of the ray's direction
  vec3 first_normal{0};              // geometric, there
  float first_photon_footprint = 0;  // area per photon at the first hit, where the radiance is made of photons; else 0
  std::uint32_t gathered = no_id;    // material of the last surface at which PathCaustics gathered; none: where it began
  bool in_core = false;              // the path left that one in a direction in which caustics are the path's own
};

// Paths may end early at diffuse surfaces whose indirect light something else knows.
class PathEnd {
 public:
  virtual ~PathEnd() = default;
  // The radiance that a surface reflects towards wo apart from direct light, after `depth` scattering events; empty: the path
  // goes on.
  virtual std::optional<Rgb> reflected(const SurfacePoint& point, const Diffuse& material, const vec3& wo, int depth) const = 0;
  // How direct light is sampled at such a surface: `light` for all of it; `bsdf` if `reflected` includes it but for lights that
  // no ray can hit.
  MisMode direct = MisMode::light;
};

// Light by way of specular surfaces that something else knows, a caustic map: paths gather it where they meet other surfaces,
// and count no emission that they meet beyond specular ones, but for directions that are left to them.
class PathCaustics {
 public:
  virtual ~PathCaustics() = default;
  virtual bool gathers_at(std::uint32_t material) const = 0;
  // Is light from a direction of this BSDF density (1/sr) left to paths?
  virtual bool leaves(std::uint32_t material, float pdf_bsdf) const = 0;
  // The part of the rest that a surface of such a material reflects towards wo, with `depth` scattering events before that one.
  virtual Rgb reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                        int depth) const = 0;
};

// Traces paths together, event by event, so that their rays are traced in batches; each gives the same result as alone. They
// already have `depth` scattering events behind them. With `count_emission` false, light that a first hit (or the environment a
// first ray escapes to) emits is left out: the caller has sampled it.
void trace_paths(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                 bool count_emission, const PathEnd* end = nullptr, const PathCaustics* caustics = nullptr);

// A camera ray for a pixel, its place drawn from the pixel's filter (and over the lens where it is open).
Ray sample_camera_ray(const RenderContext& context, ivec2 pixel, Sampler& sampler);
// The weight of the sample `index` of a pixel: 1, or -1 where it fell on a negative part of the filter.
inline float sample_weight(const RenderContext& context, ivec2 pixel, std::uint32_t index) {
  const auto& filter = context.scene.filter;
  return filter ? filter->weight(pixel_index(pixel, context.resolution), index) : 1.0f;
}
inline bool has_signed_filter(const RenderContext& context) {
  return context.scene.filter && context.scene.filter->is_signed();
}
// The camera path of a pixel's sample `index`, before its first hit.
PathSample camera_path(const RenderContext& context, ivec2 pixel, SamplerKind kind, std::uint32_t index);
// Those of a tile, row by row.
void camera_paths(const RenderContext& context, const Tile& tile, SamplerKind kind, std::uint32_t index,
                  std::vector<PathSample>& paths);

// Square tiles, whose camera paths are traced together. 16 pixels a side: enough rays for a batch to pay, enough tiles for many
// threads. They are numbered row by row.
std::size_t path_tile_count(ivec2 resolution);
Tile path_tile(ivec2 resolution, std::size_t number);

IntegratorEntry path_entry();

}  // namespace etendue
