// Shared by the light paths and camera paths of vertex connection and merging: settings, and how a path continues.
#pragma once

#include "framework/core/sampler.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/bidirectional/vcm_correlation.h"
#include "integrators/bidirectional/vcm_mis.h"
#include "integrators/paths/wavefront.h"

namespace etendue {

struct VcmSettings {
  bool connect = true;  // hits, next events and connections beside splats; without: splats alone, of weight one
  int max_depth = 64;
  int roulette_depth = 5;
  std::uint32_t paths = 1;  // light paths an iteration
  SamplerKind sampler = SamplerKind::sobol;
  float merge_radius = 0;    // m; 0: no merging
  bool wall_test = true;     // merges across a wall do not count
  bool correlation = false;  // weights by integrators/bidirectional/vcm_correlation.h, not by partial sums

  // n pi r^2 of the merges that each vertex could have been made by, and its inverse ([Georgiev2012b] eq. 20).
  float mis_merge() const { return static_cast<float>(paths) * pi * square(merge_radius); }
  float merge_area() const { return pi * square(merge_radius); }
  float mis_connect() const { return merge_radius > 0 ? 1 / mis_merge() : 0; }
};

// A path under way from either end.
struct SubPath {
  Rgb throughput{1};   // of a light path: power in W, for one path in total
  float roulette = 1;  // over the throughput: what survival is measured against, free of refraction's eta^2
  MisPartials mis{};
  float pdf_bsdf = 0;  // with which the ray was sampled; 0: delta lobe, or its first
};

// Asks for a direction in which a path may go on.
inline void ask_direction(BsdfBatch& batch, const SurfacePoint& point, const vec3& wo, Sampler& sampler) {
  const float u_lobe = sampler.get_1d();
  batch.ask(point, wo, {u_lobe, sampler.get_2d()});
}

// Sends a path on from its vertex number `depth` + 1 in the direction that it got; false where it ends. `trail`, where it is
// kept, ends with that vertex.
inline bool scatter(SubPath& path, Ray& ray, const VcmSettings& settings, const SurfacePoint& point,
                    const ReversibleSample& next, Sampler& sampler, int depth, TransportMode mode,
                    std::vector<TrailVertex>* trail) {
  if (!next) return false;
  const vec3 wo = -ray.direction;
  const float cos_out = std::abs(glm::dot(next.wi, point.normal));
  if (next.specular) {
    // Per solid angle: one for mirrors, cos_in / (eta^2 cos_out) at refraction.
    const float cos_in = glm::dot(next.wi, point.shading_normal);
    if (cos_in == 0) return false;  // rounded into the surface
    const float bend = std::abs(glm::dot(wo, point.shading_normal) / cos_in);
    const float stretch = next.transmitted ? bend / square(next.eta) : 1;
    path.mis.scatter_specular(cos_out, stretch);
    if (trail) trail->back().leave(cos_out, 1, stretch, true);
  } else {
    path.mis.scatter(settings.mis_merge(), settings.mis_connect(), cos_out, next.pdf_solid_angle, next.pdf_reverse);
    if (trail) trail->back().leave(cos_out, next.pdf_solid_angle, next.pdf_reverse, false);
  }
  path.throughput *= next.weight;
  if (next.transmitted) path.roulette *= mode == TransportMode::radiance ? square(next.eta) : 1 / square(next.eta);
  path.pdf_bsdf = next.pdf_solid_angle;
  ray = spawn_ray(point, next.wi);
  if (depth + 1 < settings.roulette_depth) return true;
  return survives_roulette(path.throughput, survival_of(path.throughput, path.roulette), sampler);
}

}  // namespace etendue
