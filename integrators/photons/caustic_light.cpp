#include "integrators/photons/caustic_light.h"

#include <algorithm>

namespace etendue {

namespace {

// Photons are new in every iteration, whose noise is small beside that of the paths by a few of them already: fewer than a map
// that stays has make less blur, and gathers that take less time.
constexpr int nearest_photons = 10;

PhotonMapsParams maps_of(int caustic_photons) {
  PhotonMapsParams maps;
  maps.photons = 1;  // there is no global map
  maps.caustic_photons = caustic_photons;
  maps.caustic_map = CausticMap::on;
  maps.k = nearest_photons;
  maps.carry_below = 0;  // all but delta lobes are gathered at
  return maps;
}

}  // namespace

CausticLight::CausticLight(const RenderContext& context, int caustic_photons, int max_depth, SamplerKind sampler, float narrow)
    : maps_(maps_of(caustic_photons), ""), max_depth_(max_depth) {
  maps_.prepare(context, {0, max_depth, sampler, false, true});
  narrow = std::min(PhotonMapsParams().carry_below, narrow);
  if (std::ranges::none_of(context.scene.lights, is_delta)) lobes_.emplace(context.scene, narrow, LobeTails::gathered);
}

void CausticLight::trace(RenderContext& context, std::uint32_t iteration) {
  if (weight_ > 0) emission_.emitted(brought_);
  Sampler numbers(SamplerKind::independent, context.seed, Stream::light_path, hash_keys(3), iteration);
  weight_ = emission_.weight(numbers.get_1d());
  if (weight_ == 0) return;
  maps_.trace_caustics(context, iteration);
}

}  // namespace etendue
