// Camera paths: emission they meet, next-event estimation, and connections to light paths and merges with them.
#pragma once

#include "integrators/bidirectional/vcm_light_paths.h"
#include "integrators/bidirectional/vcm_merges.h"

namespace etendue {

// A camera path under way.
struct CameraWalk {
  SubPath path;
  Sampler sampler;
  std::span<const LightVertex> lights;  // of its light path
  std::size_t light_bsdf;               // of the first of them
  Rgb* radiance;                        // what it gathers
  CameraTrail* trail;                   // null where weights do not ask for it
};

// Traces the camera paths of a tile together, event by event, and their shadow rays at the end.
class VcmCameraPaths {
 public:
  VcmCameraPaths(const RenderContext& context, const VcmSettings& settings, const LightPaths& light_paths,
                 const VcmMerges& merges)
      : context_(context), settings_(settings), light_paths_(light_paths), merges_(merges) {
    densities_.count_strategies(static_cast<float>(settings.paths), settings.merge_area());
  }

  // Adds what the paths of iteration `index` gather, pixel by pixel as for_pixels has them.
  void trace(const Tile& tile, std::uint32_t index, std::span<Rgb> radiance);

 private:
  // A vertex of a camera path, with `depth` events before it.
  struct Vertex {
    const SurfacePoint& point;
    const Bsdf& bsdf;
    vec3 wo;
    const CameraWalk& walk;
    int depth;
  };
  struct Gain {
    Rgb* radiance;
    Rgb value;
  };

  bool meet(CameraWalk& walk, Ray& ray, const SurfacePoint* met, int depth);
  // Appends a vertex to the trail.
  void follow(CameraTrail& trail, const Ray& ray, int depth, float cos_in) const;
  Rgb emitted_with_mis(const CameraWalk& walk, const Ray& ray, const SurfacePoint* point, int depth);
  void next_event(const Vertex& vertex, Sampler& sampler);
  void connect(const Vertex& vertex, const LightVertex& light, const Bsdf& light_bsdf);
  void merge(const Vertex& vertex);
  void finish();

  const RenderContext& context_;
  const VcmSettings& settings_;
  const LightPaths& light_paths_;
  const VcmMerges& merges_;
  std::vector<CameraTrail> trails_;  // of the paths, where weights ask for them
  std::vector<Bsdf> light_bsdfs_;    // at the vertices of the light paths: each is joined to several camera vertices
  PathDensities densities_;
  std::vector<Gain> gains_;
  std::vector<Ray> shadow_rays_;  // of the gains
  std::vector<VcmMerges::Conditional> conditional_;
};

}  // namespace etendue
