// The global photon map and the caustic map beside it, for all methods that keep whole maps ([Jensen1996]).
//
// The caustic map exists where the scene needs it (SceneNeeds::caustic_map) or has a narrow rough lobe, and the global map is
// not simply seen: it would show caustics as well. Without a caustic map the global one holds the caustic photons too. The
// global map is seen directly, and then holds indirect photons only; or at the ends of rays from the rough vertices that are
// seen, and then holds direct, caustic and indirect photons.
//
// With `photons` = 0 a pilot pass decides how many photons the global map has for gather rays. Where little of the light
// reaches what is seen, gather rays would otherwise find only a few photons: their noise would be that of the whole image, and
// their kernels would reach far beyond edges and under doors.
//
// The pilot's photons are the first map of methods whose map grows. A cache's caustic map that is new in every iteration has
// three photons a pixel, which take about as long as the pixels' own paths. Iterations average its noise. So in iteration n the
// disc over k of them counts in its inner n^(-1/3) alone: blur and noise then both fall as fast as they can together, as with
// the radii of [Knaus2011] for alpha = 2/3. Kernels over fewer than k would take less time, and make too little of light of low
// discrepancy. Where photons of such a map lie evenly, kernels are wider (photon_gather.h).
//
// With an emission other than by power, camera paths (and gather rays) mark where each map will be looked up: within twice the
// radius that k photons need if half of those emitted reach the area that is seen. With emission by visibility, which brings no
// light elsewhere, that is the largest radius of the search, too.
#pragma once

#include "framework/structure_names.h"
#include "integrators/photons/emission/visible_region.h"
#include "integrators/photons/final_gather.h"

#include <string>

namespace etendue {

enum class CausticMap : std::uint8_t { where_needed, on, off };
constexpr auto names_of(CausticMap) { return std::array{"auto", "on", "off"}; }

struct PhotonMapsParams {
  int photons = 200000;
  int caustic_photons = 0;
  int k = 50;
  float radius = 0;
  Kernel kernel = Kernel::epanechnikov;
  int precompute = 16;
  bool follow_near = false;
  CausticMap caustic_map = CausticMap::where_needed;
  float carry_below = 0.25f;
  bool side_test = true;
  Edges edges = Edges::disc;
  PhotonEmission emission = PhotonEmission::power;
  std::string structure = "hash-grid";
};

template <class Visitor>
void describe_photon_maps(Visitor& v, PhotonMapsParams& p) {
  v.integer(
      "photons", p.photons, 0, 2000000000, "photons",
      "emitted for the global map; 0: 200,000, for gather rays up to tenfold and 32 a pixel where few land on what is seen");
  v.integer("caustic_photons", p.caustic_photons, 0, 2000000000, "photons",
            "emitted for the caustic map, where there is one; 0: 200,000; new in every iteration of a cache, three a pixel, "
            "at least 20,000 and 800 k");
  v.integer(
      "k", p.k, 0, 1000000, "photons",
      "nearest photons whose reach is the kernel's radius, at least 2; 0: the radius is fixed; all of them are added up, which "
      "takes time in proportion");
  v.number("radius", p.radius, 0, 1e12, "m", "kernel radius, with k its upper bound; 0: from the density of the photons");
  v.choice("kernel", p.kernel, "density kernel, normalised");
  v.integer("precompute", p.precompute, 0, 1000000, "photons",
            "photons for each sample point that holds irradiance for gather rays, once one asked; 0: they gather photons "
            "themselves, as most do where this is more than k");
  v.flag("follow_near", p.follow_near,
         "gather rays shorter than the kernel at their ends are traced on, for corners and thin walls");
  v.choice("caustic_map", p.caustic_map,
           "auto: where the scene needs it, and gather rays or records look up the other map or caustic_photons is given, or "
           "edges is hull; off: one for all");
  describe_carry_below(v, p.carry_below);
  v.flag("side_test", p.side_test, "refuse photons from another side of a wall or corner");
  v.choice("edges", p.edges,
           "what photons are divided by: the whole disc, its part that the point sees, or their own hull (caustics that are "
           "seen: the whole disc); caustics that are new in every iteration always by the part that the point sees");
  v.choice("emission", p.emission,
           "of photons: by the lights' power, more of it where photons will be seen, or by paths that are seen alone");
  v.choice("structure", p.structure, point_structure_names, "what finds the photons");
}

// How the maps will be used.
struct PhotonMapsUse {
  int gather_rays = 0;  // from a rough vertex that is seen; 0: the global map is seen directly
  int max_depth = 64;
  SamplerKind sampler = SamplerKind::sobol;
  bool interpolated = false;  // what the global map shows: records would blur its caustics
  bool new_caustics = false;  // in every iteration, whose number is then the pass
};

class PhotonMaps {
 public:
  // Throws Error for wrong combinations of parameters, with the name of the `method`.
  PhotonMaps(const PhotonMapsParams& params, const std::string& method);

  // Finds where photons matter; traces nothing yet.
  void prepare(const RenderContext& context, const PhotonMapsUse& use);
  // Maps of different passes are independent, but for the radius of a caustic map of fewer than k photons, which goes by where
  // those of earlier passes landed. `share`: of the photons; where the pilot had as many, its map stays.
  void trace_global(RenderContext& context, std::uint32_t pass, float share = 1);
  // Nothing where there is no caustic map.
  void trace_caustics(RenderContext& context, std::uint32_t pass);

  int photons() const { return photons_; }  // emitted for the global map
  // A map that grows begins with these: kernels of fewer would lose too much light at edges and corners. 0: not known.
  int photons_to_begin_with() const { return first_photons_; }
  int caustic_photons() const { return separate_caustics_ ? caustic_photons_ : 0; }  // for a caustic map
  const RoughMaterials& rough_materials() const { return *rough_materials_; }
  const PhotonMap& global() const { return global_; }
  bool empty() const { return global_.size() == 0 && caustic_.size() == 0; }
  // Caustics at a rough vertex, apart from those that are part of `seen_directly`; of directions of a BSDF density below
  // `tail_density`.
  Rgb caustics(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int max_scatterings,
               float tail_density = infinity) const;
  // The global map's light where it is seen directly.
  Rgb seen_directly(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                    int max_scatterings) const {
    return global_.radiance(context, point, bsdf, wo, global_seen_, max_scatterings);
  }
  FinalGather gather(const RenderContext& context, int rays, bool by_photons) const {
    return {context,    *rough_materials_,   global_,     irradiance_.get(), rays, use_.max_depth,
            by_photons, params_.follow_near, use_.sampler};
  }

 private:
  int enough_photons(const RenderContext& context);
  void precompute(const RenderContext& context, PhotonPass pass);
  void mark_seen(const RenderContext& context);
  PhotonPass pass_of(int count, std::uint64_t key, int max_scatterings, PhotonHistory keep, const VisibleRegion* visible) const;
  Photons trace(const RenderContext& context, const PhotonPass& pass) const;
  float radius_of_few(const std::vector<vec3>& positions);
  void build(const RenderContext& context, PhotonMap& map, Photons photons, Edges edges, float radius, float share = 1,
             bool widen = false);

  PhotonMapsParams params_;
  PhotonMapsUse use_;
  int photons_ = 0;          // of the global map
  int first_photons_ = 0;    // of a map that grows
  int pilots_ = 0;           // of the map that the pilot left as the global one; 0: none
  int caustic_photons_ = 0;  // of the caustic map, where there is one
  bool separate_caustics_ = false;
  bool holds_caustics_ = false;  // the global map, to be seen directly
  Edges global_edges_ = Edges::disc;
  float wide_radius_ = 1;
  std::vector<vec3> earlier_;               // where caustic photons of earlier iterations landed, as long as these are few
  PhotonHistory global_seen_ = photon_any;  // histories the global map answers for where it is seen directly
  std::unique_ptr<RoughMaterials> rough_materials_;
  PhotonMap global_, caustic_;
  std::unique_ptr<PhotonIrradiance> irradiance_;  // of the global map, for gather rays
  std::shared_ptr<const WallGrid> walls_;         // of the map that was built last
  float largest_radius_ = infinity;
  std::unique_ptr<VisibleRegion> seen_, gathered_;  // by camera paths, and by gather rays; null where not needed
};

}  // namespace etendue
