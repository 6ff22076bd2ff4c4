// Photon mapping ([Jensen1996], [Jensen2001]): photons are traced from the lights once, and camera paths gather their density.
//
// The camera path passes specular-like vertices (see integrators/photons/photons.h) to each rough vertex R it meets. There,
// with C for a specular-like event:
//
//   direct      L R C* E           next-event estimation: one light sample, and close to large lamps a BSDF sample
//   caustic     L C+ R C* E        the caustic map: photons of its own, whose paths end at their first rough vertex; or, with
//                                  final_gather = 0, the global map
//   indirect    L (C|R)* R C* R C* E
//                 final_gather = 0: the global map, which then holds no direct photons
//                 final_gather > 0: that many rays (integrators/photons/final_gather.h) through C* to the next rough vertex,
//                 where the global map, which then holds direct, caustic and indirect photons, is gathered. They collect no
//                 emission: a ray that ends on a light has found a path of the first two rows.
//   L C* E                         emission the camera path meets (MIS-weighted with light sampling after a narrow rough lobe)
//
// Both maps: integrators/photons/photon_maps.h. Emission and direct light take further camera paths where they scatter more
// than photons do (integrators/photons/direct_shares.h).
//
// Biased: the maps are traced once, so their noise and blur stay however many camera samples are taken. `retrace` makes new
// maps for every iteration; then only the blur of the kernel's radius stays. An iteration is one sample per pixel.
#pragma once

#include "integrators/photons/direct_shares.h"
#include "integrators/photons/photon_maps.h"

namespace etendue {

enum class GatherSampling : std::uint8_t { photons, bsdf };
constexpr auto names_of(GatherSampling) { return std::array{"photons", "bsdf"}; }

struct PhotonMapParams : PhotonMapsParams {
  int final_gather = 0;
  GatherSampling gather_sampling = GatherSampling::photons;
  bool retrace = false;
  float further_paths = 2;
  int max_depth = 0;
  SamplerKind sampler = SamplerKind::sobol;
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe(Visitor& v, PhotonMapParams& p) {
  describe_photon_maps(v, p);
  v.integer("final_gather", p.final_gather, 0, 1000000, "rays", "per visible point; 0: the global map is seen directly");
  v.choice("gather_sampling", p.gather_sampling,
           "directions of those rays: from where photons came and by the BSDF in equal parts, or by the BSDF alone");
  v.flag("retrace", p.retrace, "new maps for every iteration");
  describe_further_paths(v, p.further_paths);
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("sampler", p.sampler, "random numbers");
  describe_lights(v, p.lights);
}

IntegratorEntry photon_map_entry();

}  // namespace etendue
