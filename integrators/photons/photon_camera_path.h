// A camera path past all specular-like vertices (see integrators/photons/photons.h) to the rough vertices it meets.
//
// At a rough vertex the path ends, unless a delta lobe (a smooth coat's) is sampled there, by which it goes on. The path
// follows the core of a narrow rough lobe if the caller gathers the lobe tails, else all of it. Returned is the light that
// needs no photons: emission the path meets, and what light sampling finds at narrow rough lobes, MIS-weighted where both can
// find it.
#pragma once

#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/paths/emission.h"
#include "integrators/photons/photons.h"

namespace etendue {

struct NoTails {
  void operator()(const SurfacePoint&, const Bsdf&, const vec3&, const Rgb&, int) const {}
};

struct PhotonCameraPath {
  const RenderContext& context;
  const RoughMaterials& rough_materials;
  int max_depth;

  static constexpr int roulette_depth = 5;

  // A path under way. Many can be traced together, event by event.
  struct State {
    Rgb radiance{0}, throughput{1};
    float distance = 0;   // metres
    float eta_scale = 1;  // undoes the eta^2 of refractions, which roulette must not take for absorption
    BsdfSample last;
  };

  // Calls at_rough_vertex(point, bsdf, wo, throughput, depth, distance) at each rough vertex, with `depth` scattering events
  // before it and a way of `distance` behind it, and at_tails(point, bsdf, wo, throughput, depth) where light from directions
  // of a density below rough_materials.tail_density() is wanted, but for direct light. `path` decides where the path goes,
  // `light` which points of lights it looks at.
  template <class AtRoughVertex, class AtTails = NoTails>
  Rgb operator()(Ray ray, Sampler& path, Sampler& light, const AtRoughVertex& at_rough_vertex,
                 const AtTails& at_tails = {}) const {
    State state;
    for (int depth = 0;; ++depth) {
      const Hit hit = trace(context, ray);
      std::optional<SurfacePoint> point;
      if (hit) point = context.scene.surface_at(ray, hit);
      if (!meet(state, ray, hit ? &*point : nullptr, depth, path, light, at_rough_vertex, at_tails)) return state.radiance;
    }
  }

  // The same for what one ray met, or nothing: false if the path ends there, else it goes on along `ray`.
  template <class AtRoughVertex, class AtTails>
  bool meet(State& state, Ray& ray, const SurfacePoint* met, int depth, Sampler& path, Sampler& light,
            const AtRoughVertex& at_rough_vertex, const AtTails& at_tails) const {
    auto& [radiance, throughput, distance, eta_scale, last] = state;
    radiance += throughput * emitted_with_mis(context, ray, met, last.pdf_solid_angle);
    if (!met || depth >= max_depth) return false;

    const SurfacePoint& point = *met;
    const vec3 wo = -ray.direction;
    const Bsdf bsdf(context.scene, point);
    const bool rough = rough_materials(point.material);
    distance += glm::length(point.position - ray.origin);
    const float followed_above = rough_materials.has_tails(point.material) ? rough_materials.tail_density() : 0;
    if (rough)
      at_rough_vertex(point, bsdf, wo, throughput, depth, distance);
    else
      radiance += throughput * direct_light(context, point, bsdf, wo, light, MisMode::power, followed_above);
    if (followed_above > 0) at_tails(point, bsdf, wo, throughput, depth);
    if (rough && !bsdf.has_specular()) return false;

    const float u_lobe = path.get_1d();
    last = bsdf.sample(wo, u_lobe, path.get_2d());
    if (!last || (rough && !last.specular) || (!last.specular && last.pdf_solid_angle < followed_above)) return false;
    throughput *= last.weight;
    if (last.transmitted) eta_scale *= last.eta * last.eta;
    ray = spawn_ray(point, last.wi);
    return depth + 1 < roulette_depth || survives_roulette(throughput, survival_of(throughput, eta_scale), path);
  }
};

}  // namespace etendue
