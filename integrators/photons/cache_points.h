// Irradiance is cached on diffuse surfaces, unless they are black, and on the diffuse base under a smooth coat.
#pragma once

#include "framework/integrator.h"
#include "framework/transport/bsdf.h"
#include "integrators/photons/photons.h"

#include <functional>

namespace etendue {

// A cached surface as a camera path finds it.
struct CachePoint {
  vec3 position{0};
  vec3 normal{0}, geometric{0};  // both on the side that is seen
  vec3 origin{0};                // of rays that leave to that side
  float pixel_width = 0;         // metres per pixel, there
  int depth = -1;                // specular-like events before it; -1: nothing to cache is seen

  explicit operator bool() const { return depth >= 0; }
};

// Depth limits above which the points of all depths share records.
inline constexpr int shared_above = 16;

inline bool is_cached(const Bsdf& bsdf) {
  return bsdf.is_diffuse() ? !is_black(bsdf.diffuse_albedo()) : bsdf.has_specular() && bsdf.has_non_specular();
}

inline vec3 towards(const vec3& normal, const vec3& side, const vec3& wo) { return glm::dot(side, wo) < 0 ? -normal : normal; }

// Do both normals have wo on the same side? Where they do not, a surface reflects light from between their planes alone
// (bsdf.h), of which records, made for all that comes to the side that is seen, know nothing.
inline bool shows_one_side(const SurfacePoint& point, const vec3& wo) {
  return (glm::dot(point.shading_normal, wo) < 0) == (glm::dot(point.normal, wo) < 0);
}

// May records serve the point? Not where a mask lets light through: what arrives on the sheet and on what lies beneath differs.
inline bool takes_records(const SurfacePoint& point, const vec3& wo) {
  return shows_one_side(point, wo) && !lets_light_through(point.layer);
}

// And does the relief that wo sees receive what arrives on the surface? On slopes of 8 degrees it is a hundredth less.
inline bool is_flat(const SurfacePoint& point, const vec3& wo) {
  return std::abs(glm::dot(point.shading_normal, point.normal)) > 0.99f && takes_records(point, wo);
}

// `distance`: of the whole path from the camera.
CachePoint cache_point(const RenderContext& context, const SurfacePoint& point, const vec3& wo, float distance, int depth);

enum class Follow { arrives, ends, goes_on };

// Follows the ray through the centre of a pixel, with less than `deepest` events, to the surface at which judge(point, bsdf)
// says that it arrives. From a cached surface it goes on only through the coat.
CachePoint follow_pixel(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind sampler,
                        const std::function<Follow(const SurfacePoint&, const Bsdf&)>& judge);

// Follows the ray through the centre of a pixel to a cached surface with less than `deepest` events before it: past all other
// surfaces, or past those that are not in `rough_materials`.
CachePoint find_cache_point(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind sampler,
                            const RoughMaterials* rough_materials = nullptr);

// The same to the first of the `rough_materials`, cached or not, unless that is black.
CachePoint find_rough_point(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind sampler,
                            const RoughMaterials& rough_materials);

// The share of uniform incident light that the diffuse part reflects towards wo. A coated base, f = g T(wo) T(wi) / pi, is
// evaluated along the normal and T(wi) replaced by its cosine-weighted mean.
Rgb base_reflectance(const Scene& scene, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo);

}  // namespace etendue
