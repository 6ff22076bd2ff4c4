#include "integrators/photons/caustic_light.h"

#include "framework/core/elementary.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// Photons are new in every iteration, whose noise is small beside that of the paths by a few of them already: fewer than a map
// that stays has make less blur, and gathers that take less time.
constexpr int nearest_photons = 10, photons_a_pixel = 3, fewest_photons = 20000;

int photons_for(const CausticParams& params, ivec2 resolution) {
  if (params.caustic_photons > 0) return params.caustic_photons;
  const double wanted = static_cast<double>(photons_a_pixel) * resolution.x * resolution.y;
  return static_cast<int>(std::clamp(wanted, double{fewest_photons}, 2e9));
}

}  // namespace

std::unique_ptr<CausticLight> CausticLight::where_wanted(const RenderContext& context, const CausticParams& params,
                                                         int max_depth, SamplerKind sampler, float narrow) {
  const bool wanted =
      params.caustic_map == CausticMap::on || (params.caustic_map == CausticMap::where_needed && context.needs.caustic_map);
  if (!wanted) return nullptr;
  PhotonMapsParams maps;
  maps.photons = 1;  // there is no global map
  maps.caustic_photons = photons_for(params, context.resolution);
  maps.caustic_map = CausticMap::on;
  maps.k = nearest_photons;
  narrow = std::min(maps.carry_below, narrow);
  maps.carry_below = 0;  // all but delta lobes are gathered at
  std::unique_ptr<CausticLight> light(new CausticLight(maps, max_depth));
  light->maps_.prepare(context, {0, max_depth, sampler});
  if (std::ranges::none_of(context.scene.lights, is_delta)) light->lobes_.emplace(context.scene, narrow, LobeTails::gathered);
  return light;
}

void CausticLight::trace(RenderContext& context, std::uint32_t iteration) {
  maps_.trace_caustics(context, iteration, static_cast<float>(1 / math::cbrt(iteration + 1.0)));
}

}  // namespace etendue
