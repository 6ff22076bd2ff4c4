// Camera paths: the light they meet, next events, and what joins them to light paths.
#pragma once

#include "integrators/vcm_light_paths.h"

namespace etendue {

// Traces the camera paths of a tile's pixels and adds what they gather to `radiance`, one value a pixel of the tile, row by
// row.
class CameraPaths {
 public:
  CameraPaths(const RenderContext& context, const VcmSettings& settings, const LightPaths& light_paths)
      : context_(context), settings_(settings), light_paths_(light_paths) {}

  // Pixel `pixel` in iteration `index`, joined to one light path; `slot` is where its light goes in `finish`.
  void trace(ivec2 pixel, std::uint32_t index, Rgb& radiance);
  // Adds what depends on shadow rays.
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

  Rgb met_emission(const SubPath& path, const Hit& hit, const SurfacePoint* point, int depth) const;
  void next_event(const Vertex& vertex, Sampler& sampler, Rgb& radiance);
  void connect(const Vertex& vertex, const LightVertex& light, Rgb& radiance);

  const RenderContext& context_;
  const VcmSettings& settings_;
  const LightPaths& light_paths_;
  std::vector<Gain> gains_;
  std::vector<Ray> shadow_rays_;  // of the gains
};

}  // namespace etendue
