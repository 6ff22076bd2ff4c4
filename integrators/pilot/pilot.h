// The findings of a short run about a scene, before a method is chosen for it (integrators/choice/choose.h).
//
// The pilot looks at a small image of about `pilot_pixels` pixels, however large the real one is. It traces
//
//   paths        integrators/paths, in eight independent groups, whose scatter is the variance of path tracing;
//   camera paths to rough vertices (integrators/photons/photon_camera_path.h), with direct light sampled there: the variance of
//                what all photon methods and caches sample alike. A cosine-distributed ray from each diffuse vertex probes how
//                near the next surfaces are, which is what an irradiance cache's records go by ([Ward1988]);
//   photons      by power, of which those that land on what is seen tell how much light comes by way of specular surfaces, and
//                how much never gets to be seen.
//
// All of it is a function of (scene, seed, resolution, share), and the work is counted, not timed: about 200,000 rays, of which
// photons take a quarter.
#pragma once

#include "framework/integrator.h"

namespace etendue {

inline constexpr int pilot_pixels = 1024;
inline constexpr double least_pilot = 0.25;
inline constexpr std::size_t fewest_caustics = 128;   // of photons: fewer may have landed beside what is seen
inline constexpr double least_caustic_light = 0.003;  // of all light, above which it is looked at

// Shares are in [0, 1].
struct PilotFindings {
  double surface = 0;      // of camera paths that meet a rough vertex,
  double diffuse = 0;      // and of those a diffuse one, or the diffuse base of a coat
  double by_specular = 0;  // of rough vertices that are seen by way of mirrors or glass

  // The relMSE (framework/image/metrics.h) that one sample in each pixel leaves: of path tracing, and of direct light alone, if
  // all else were known.
  double path_error = 0, direct_error = 0;
  double rays_per_path = 0;  // shadow rays included

  double photons_seen = 0;     // of emitted photons that land where the camera sees them
  double caustic_light = 0;    // of the light that they bring there after specular events alone
  double direct_light = 0;     // and straight from a light
  double caustic_photons = 0;  // how many say so of the first
  // The part of it that no path finds: from delta lights, and from lights that are far brighter than any that paths met by way
  // of specular surfaces.
  double unmet_caustics = 0;
  // How likely a path from a diffuse vertex meets a light by way of specular events: that is how paths find caustics. Where no
  // vertex is diffuse, it is a path that leaves by the vertex's own lobe.
  double caustic_hits = 0;
  // How much denser caustic photons lie about one of them than they would if they lay evenly over what is seen.
  double caustic_contrast = 0;

  double records = 0;  // that an irradiance cache of the usual accuracy makes for the real image
  double rays = 0;     // that the pilot took
  double share = 1;    // of a whole pilot's pixels
};

// `context` is that of the real image. Time goes to the phase "pilot". `narrow`: photons follow lobes of less GGX alpha, as by
// default those of all photon methods do; 0: delta lobes alone. `share`: of the small image's pixels, in [least_pilot, 1];
// there are as many photons for any, since few of them tell of caustics.
PilotFindings run_pilot(const RenderContext& context, float narrow = 0.25f, double share = 1);

}  // namespace etendue
