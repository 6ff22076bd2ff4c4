// Unidirectional path tracing with next-event estimation and multiple importance sampling ([Kajiya1986], [Veach1995]).
//
// Unbiased up to the depth limit. Depth counts scattering events on the whole path; Russian roulette begins at
// `roulette_depth` and survives with the largest component of the throughput. The paths of a tile go on event by event, so that
// the structure is asked for many rays at once; the image is that of one path after the other, to the bit.
#pragma once

#include "framework/core/sampler.h"
#include "framework/integrator.h"
#include "framework/transport/direct_light.h"

#include <optional>
#include <span>
#include <string>

namespace etendue {

struct PathParams {
  int max_depth = 0;
  int roulette_depth = 5;
  std::string mis = "power";
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, PathParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.choice("mis", p.mis, {"power", "balance", "light", "bsdf"}, "how light and BSDF sampling share the work");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

SamplerKind parse_sampler(const std::string& name);  // of a checked parameter

struct PathSettings {
  int max_depth = 64;
  int roulette_depth = 5;
  MisMode mis = MisMode::power;
};

// A path: its first ray, the numbers that it draws, and what comes of it.
struct PathSample {
  Ray ray;
  Sampler sampler;
  Rgb radiance{0};                  // arriving along the ray
  float first_distance = infinity;  // to the first hit, in lengths of the ray's direction
  vec3 first_normal{0};             // geometric, there
  float first_grain = 0;            // area there per photon that the radiance is made of; 0: it is not
};

// Where paths may end early: at surfaces whose indirect light something else knows.
class PathEnd {
 public:
  virtual ~PathEnd() = default;
  // What a surface reflects towards wo but for its direct light, after `depth` scattering events; empty: the path goes on.
  virtual std::optional<Rgb> reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth) const = 0;
  // How its direct light is sampled there: `light` for all of it; `bsdf` where `reflected` has all but that of lights that no
  // ray can find.
  MisMode direct = MisMode::light;
};

// Traces paths together, event by event, so that their rays are asked in batches; what comes of each is what would by itself.
// They already have `depth` scattering events behind them. With `count_emission` false, light that a first hit (or the
// environment a first ray escapes to) emits is left out: the caller has sampled it.
void trace_paths(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                 bool count_emission, const PathEnd* end = nullptr);

// A camera ray for a pixel, jittered over it (and over the lens where it is open).
Ray sample_camera_ray(const RenderContext& context, ivec2 pixel, Sampler& sampler);

IntegratorEntry path_entry();

}  // namespace etendue
