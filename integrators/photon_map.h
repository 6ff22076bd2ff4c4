// Photon mapping ([Jensen1996], [Jensen2001]): photons traced from the lights once, their density gathered from the camera.
//
// The camera path follows what carries light (see integrators/photons.h) to each receiver R it meets. There, with C for an
// event that carries:
//
//   direct      L R C* E           next-event estimation, one light sample
//   caustic     L C+ R C* E        the caustic map: photons of its own, whose paths end at their first receiver
//   indirect    L (C|R)* R C* R C* E
//                 final_gather = 0: the global map, which then holds indirect photons only
//                 final_gather > 0: that many rays (integrators/final_gather.h) through C* to the next receiver, where the
//                 global map, which then holds direct, caustic and indirect photons, is gathered. They collect no emission: a
//                 ray that ends on a light has found a path of the first two rows.
//   L C* E                         emission the camera path meets (weighed against light sampling after a narrow rough lobe)
//
// The caustic map exists where the scene needs it (SceneNeeds::caustic_map) or has a rough lobe that carries; without it the
// global map holds the caustic photons too.
//
// With an emission other than by power, camera paths (and gather rays) mark where each map is going to be looked at: within
// twice what k photons need if half of those emitted reach the area that is seen. With emission by visibility, which brings no
// light elsewhere, that is the largest radius of the search, too.
//
// Biased: the maps are traced once, so their noise and blur stay however many camera samples are taken. `retrace` makes new
// maps for every iteration; then only the blur of the kernel's radius stays. An iteration is one sample per pixel.
#pragma once

#include "framework/integrator.h"
#include "framework/structure_names.h"

#include <string>

namespace etendue {

struct PhotonMapParams {
  int photons = 200000;
  int caustic_photons = 200000;
  int k = 50;
  float radius = 0;
  std::string kernel = "epanechnikov";
  int final_gather = 0;
  std::string gather_sampling = "photons";
  int precompute = 0;
  std::string caustic_map = "auto";
  float carry_below = 0.25f;
  bool side_test = true;
  std::string edges = "disc";
  bool retrace = false;
  std::string emission = "power";
  int max_depth = 0;
  std::string structure = "hash-grid";
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, PhotonMapParams& p) {
  v.integer("photons", p.photons, 1, 2000000000, "photons", "emitted for the global map");
  v.integer("caustic_photons", p.caustic_photons, 1, 2000000000, "photons", "emitted for the caustic map, where there is one");
  v.integer("k", p.k, 0, 1000000, "photons",
            "nearest photons whose reach is the kernel's radius, at least 2; 0: the radius is fixed");
  v.number("radius", p.radius, 0, 1e30, "m", "kernel radius, with k its upper bound; 0: from the density of the photons");
  v.choice("kernel", p.kernel, {"box", "cone", "epanechnikov", "gaussian"}, "density kernel, normalised");
  v.integer("final_gather", p.final_gather, 0, 1000000, "rays", "per visible point; 0: the global map is seen directly");
  v.choice("gather_sampling", p.gather_sampling, {"photons", "bsdf"},
           "directions of those rays: from where photons came and by the BSDF in equal parts, or by the BSDF alone");
  v.integer("precompute", p.precompute, 0, 1000000, "photons",
            "one in so many holds its irradiance for gather rays to look up; 0: they gather photons themselves");
  v.choice("caustic_map", p.caustic_map, {"auto", "on", "off"}, "auto: where the scene needs it; off: one map for all");
  v.number("carry_below", p.carry_below, 0, 1, "GGX alpha", "rough lobes narrower than this are followed, not gathered");
  v.flag("side_test", p.side_test, "refuse photons from another side of a wall or corner");
  v.choice("edges", p.edges, {"disc", "visible", "hull"},
           "what photons are divided by: the whole disc, its part that the point sees, or their own hull");
  v.flag("retrace", p.retrace, "new maps for every iteration");
  v.choice("emission", p.emission, {"power", "importance", "visibility"},
           "of photons: by the lights' power, more of it where photons will be seen, or by paths that are seen alone");
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("structure", p.structure, point_structure_names, "what finds the photons");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

IntegratorEntry photon_map_entry();

}  // namespace etendue
