// Merging: light vertices within a radius of a camera vertex are gathered there like photons.
#pragma once

#include "integrators/bidirectional/vcm_light_paths.h"
#include "integrators/photons/wall_grid.h"

#include <memory>
#include <string>

namespace etendue {

// Holds what a camera path keeps of its vertices, and the distance to its first one.
struct CameraTrail {
  std::vector<TrailVertex> vertices;
  float first_distance_squared = 0;
};

class VcmMerges {
 public:
  // Sorts all vertices of the light paths along a space-filling curve and builds `structure` over them.
  void build(const RenderContext& context, const LightPaths& light_paths, const VcmSettings& settings,
             const std::string& structure);

  // A merge that counts only if no wall stands between the point and the vertex.
  struct Conditional {
    Rgb radiance;
    Ray way;
    vec3 landed;  // of the vertex
  };

  // Radiance towards wo from a surface that a camera path reaches with `depth` events before it, divided among the strategies;
  // what depends on walls is appended to `conditional` instead. A kernel of constant height: the weights stand for it.
  Rgb radiance(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const MisPartials& camera, int depth,
               const CameraTrail& trail, std::vector<Conditional>& conditional) const;

  // The median over points of the distance to the k-th nearest vertex; 0 where there are fewer.
  static float usual_distance(const RenderContext& context, const LightPaths& light_paths, std::span<const vec3> points,
                              std::size_t k, const std::string& structure);

 private:
  struct Photon {
    vec3 wo;
    float flown;
    Rgb power_over_cosine;  // W, for one path in total, over the geometric cosine where it landed
    float vcm, vm;
    std::int32_t events;
  };

  VcmSettings settings_;
  std::vector<vec3> positions_;
  // Holds copies of each photon's densities where weights ask for them, so that one look finds them.
  struct Followed {
    TrailLight light;
    Trail vertices;
  };

  std::vector<Photon> photons_;
  std::vector<Followed> followed_;
  std::vector<Layer> layers_;  // empty where nothing is masked
  std::unique_ptr<PointQuery> query_;
  std::shared_ptr<const WallGrid> walls_;  // null: not asked for
};

}  // namespace etendue
