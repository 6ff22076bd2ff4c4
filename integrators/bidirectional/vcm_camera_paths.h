// Camera paths: emission they meet, next-event estimation, and connections to light paths and merges with them.
#pragma once

#include "integrators/bidirectional/vcm_light_paths.h"
#include "integrators/bidirectional/vcm_merges.h"

namespace etendue {

// Traces camera paths one after the other; the shadow rays of all are traced together at the end.
class CameraPaths {
 public:
  CameraPaths(const RenderContext& context, const VcmSettings& settings, const LightPaths& light_paths, const VcmMerges& merges)
      : context_(context), settings_(settings), light_paths_(light_paths), merges_(merges) {
    densities_.count_strategies(static_cast<float>(settings.paths), settings.merge_area());
  }

  // Adds what a path of iteration `index` gathers, some of it in `finish`: until then `radiance` must stay where it is.
  void trace(ivec2 pixel, std::uint32_t index, Rgb& radiance);
  void finish();

 private:
  // A vertex of a camera path, with `depth` events before it.
  struct Vertex {
    const SurfacePoint& point;
    const Bsdf& bsdf;
    vec3 wo;
    const SubPath& path;
    int depth;
  };
  struct Gain {
    Rgb* radiance;
    Rgb value;
  };

  // Appends a vertex to the trail.
  void follow(const SubPath& path, float distance, float cos_in);
  Rgb emitted_with_mis(const SubPath& path, const Hit& hit, const SurfacePoint* point, int depth);
  void next_event(const Vertex& vertex, Sampler& sampler, Rgb& radiance);
  void connect(const Vertex& vertex, const LightVertex& light, Rgb& radiance);
  void merge(const Vertex& vertex, Rgb& radiance);

  const RenderContext& context_;
  const VcmSettings& settings_;
  const LightPaths& light_paths_;
  const VcmMerges& merges_;
  CameraTrail trail_;
  PathDensities densities_;
  std::vector<Gain> gains_;
  std::vector<Ray> shadow_rays_;  // of the gains
  std::vector<VcmMerges::Conditional> conditional_;
};

}  // namespace etendue
