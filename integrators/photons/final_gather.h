// Final gathering: the light that a rough vertex reflects from other rough vertices, by rays to these and a photon map there.
//
// Rays pass specular-like vertices, end at the next rough vertex and collect no emission. Their directions are sampled by the
// BSDF, or by an even mixture of the BSDF and the directions from which the photons about the point came ([Jensen1995]);
// divided by the mixture's density, the estimate is unbiased given the map, and at most twice as noisy as the BSDF's alone
// where the photons mislead. Ray j of iteration i (a camera sample's number, where a pixel takes several) is point i * rays + j
// of one sequence, so that rays stratify each other within and over iterations.
//
// A ray shorter than the kernel's radius at its end sees less than the density resolves: corners, where the kernel reaches
// beyond the edge, and light that leaks under walls. With `follow_near` such a ray takes direct light from a light sample at
// its end, caustics from the map, and is continued for the rest, as [Jensen1996] computes light accurately at short distances.
#pragma once

#include "integrators/photons/photon_gather.h"
#include "integrators/photons/photon_irradiance.h"

namespace etendue {

struct FinalGather {
  const RenderContext& context;
  const RoughMaterials& rough_materials;
  const PhotonMap& map;                // of photons of every history
  const PhotonIrradiance* irradiance;  // of that map, or null
  int rays, max_depth;
  bool by_photons, follow_near;
  SamplerKind sampler;

  // At a point with `depth` events before it; `key` is unique to it in this iteration.
  Rgb operator()(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, std::uint64_t key,
                 std::uint32_t iteration) const;
  // Radiance from photons along a ray that meets `hit`, with `depth` events behind it, past specular-like vertices.
  // `photon_footprint`: area per photon if the ray's first hit is a rough vertex, else 0.
  Rgb along(Ray ray, Hit hit, int depth, Sampler& sampler, float* photon_footprint = nullptr) const;

 private:
  PhotonMap::Estimate reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int max_scatterings) const;
};

}  // namespace etendue
