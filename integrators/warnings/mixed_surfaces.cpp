#include "integrators/warnings/mixed_surfaces.h"

#include "framework/core/units.h"
#include "framework/transport/ray_tools.h"
#include "integrators/photons/photon_maps.h"
#include "integrators/warnings/methods.h"
#include "integrators/warnings/seen_pixels.h"

namespace etendue {

std::string surfaces_mixed(const RenderContext& context, const std::string& method, const ParamMap& params) {
  constexpr std::array keeps_apart{"path", "light-trace", "guided"};
  const bool gathers_caustics = is_set(params, "caustic_map", name_of(CausticMap::on)) ||
                                (context.needs.caustic_map && !is_set(params, "caustic_map", name_of(CausticMap::off)));
  if (!context.needs.masks || is_among(keeps_apart, method) || is_bdpt(context, method, params)) return "";
  if (is_among(by_caustic_map, method) && !gathers_caustics) return "";  // records keep them apart
  const float near = 0.01f * glm::length(context.bounds.diagonal());
  const double share = share_of_pixels(context, [&](const Ray& ray, std::size_t) {
    const Hit seen = trace(context, ray);
    if (!seen) return false;
    const SurfacePoint point = context.scene.surface_at(ray, seen);
    for (const vec3& side : {point.normal, -point.normal}) {
      const Hit other = trace(context, spawn_ray(point, side, near));
      if (!other) continue;
      const Layer layer = context.scene.layer_at(other);
      if (lets_light_through(point.layer | layer) && share_light(point.layer, layer)) return true;
    }
    return false;
  });
  if (share < fewest_pixels) return "";
  return fmt::format(
      "{} of what is seen are surfaces of one shape, less than 1 % of the scene's size apart, that let a part of the light "
      "through: {} may take light on one for light on the other; path keeps them apart",
      format_percent(share), method);
}

}  // namespace etendue
