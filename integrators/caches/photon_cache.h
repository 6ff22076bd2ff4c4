// A cache of irradiance filled from a photon map, in place of a final gather for each camera sample ([Jensen1996],
// [Christensen1999]; records, metrics and gradients as in integrators/caches/irradiance_cache.h).
//
// The camera path passes specular-like vertices to each rough vertex it meets (integrators/photons/photon_camera_path.h).
// Direct light is sampled there as in irradiance-cache, caustics are those of the caustic map, which exists where the scene
// needs it (integrators/photons/photon_maps.h); indirect light is interpolated between records on diffuse surfaces and the
// diffuse base under a smooth coat. Records are filled by
//
//   gather    a stratified hemisphere of rays, each of which ends at its first rough vertex in the global map's density. The
//             first hits' distances give all metrics and gradients of the other caches, the photons all further bounces: a ray
//             costs one ray and one look-up, however dark or intricate the scene
//   density   the global map's density at the record itself, without rays. It has no distances and no gradients. What bounds
//             its record is the kernel: nothing finer than its radius is known, so at the usual accuracy (0.2) the record
//             serves as far as its kernel reached, within the spacings' bounds, at other accuracies in proportion. Curved
//             surfaces count as flat over the kernel
//
// Where no record serves, and on rough vertices that are not cached (rough metals and plastics), one gather ray is traced per
// camera sample, or the global map is seen directly.
//
// The cache refines as irradiance-cache does (integrators/caches/records/cache_progress.h). With `retrace`, photons are new
// too: the caustic map's in every iteration; the global map's as often as the records begin another pass over their
// hemispheres, so that the passes of a record see independent maps but for those it was made with; for `density` in every
// iteration, with new records on it.
//
// A cache can be saved and loaded as irradiance-cache's can (record_file.h): what its hemispheres gathered is what took time;
// the maps are traced again, for what no record answers. Where `density` makes new records in every iteration there is nothing
// to keep.
//
// The standard error it states leaves out the kernel's blur. Without `retrace` it includes the caustic map's noise at a point,
// which is too much where a pixel is wider than a kernel, and none with `k` = 0.
//
// By default a pilot decides how many photons the global map has (integrators/photons/photon_maps.h). The map grows to that
// number as the error that records state asks for (cache_progress.h), from the photons of the pilot on. With each step of its
// growth records are made anew, so that no blur of coarser maps stays in them; what they gave to pixels fades by its weight.
//
// It is biased by the blur of the kernel's radius and its loss at edges (at gather rays' ends, or where it is seen). Against
// that loss photons are by default divided by their own hull. The hull takes them for independent, and underestimates by 0.6 %
// the light of those that come straight from a light, which have low discrepancy. With `refine` and `retrace` all else falls
// with iterations, noise and interpolation error alike; without `retrace` the one map's own noise stays, without `refine` that
// of the records. Depth as in irradiance-cache: records serve the camera depth they were made at, or all depths where the limit
// is above 16.
#pragma once

#include "integrators/caches/record_cache.h"
#include "integrators/photons/photon_maps.h"

namespace etendue {

enum class PhotonFill : std::uint8_t { gather, density };
constexpr auto names_of(PhotonFill) { return std::array{"gather", "density"}; }

struct PhotonCacheParams : PhotonMapsParams, CacheParams {
  PhotonCacheParams() {
    photons = 0;
    follow_near = true;
    edges = Edges::hull;  // a disc's loss at edges darkens whole rooms
  }

  PhotonFill fill = PhotonFill::gather;
  bool retrace = true;
  std::string record_structure = "cells";
};

template <class Visitor>
void describe(Visitor& v, PhotonCacheParams& p) {
  v.choice("fill", p.fill,
           "records from hemispheres of rays that end in the photon map, or from the photons about them: no samples, "
           "gradients, precompute or follow_near then, and no metric of Hessians");
  v.flag("retrace", p.retrace, "new photons: for caustics in every iteration, for records at each pass over them");
  describe_cache(v, p);
  describe_photon_maps(v, p);
  v.choice("record_structure", p.record_structure, record_structure_names, "what finds the records");
}

IntegratorEntry photon_cache_entry();

}  // namespace etendue
