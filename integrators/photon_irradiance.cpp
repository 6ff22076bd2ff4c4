#include "integrators/photon_irradiance.h"

#include "framework/core/parallel.h"

namespace etendue {

PhotonIrradiance::PhotonIrradiance(const RenderContext& context, const PhotonMap& map, int every,
                                   std::unique_ptr<PointQuery> query)
    : query_(std::move(query)), reach_(map.radius()) {
  const Photons& photons = map.photons();
  for (const std::uint16_t scatterings : photons.scatterings) longest_ = std::max<int>(longest_, scatterings);
  const std::size_t count = (photons.size() + static_cast<std::size_t>(every) - 1) / static_cast<std::size_t>(every);
  position_.resize(count);
  normal_.resize(count);
  irradiance_.resize(count);
  radius_.resize(count);
  parallel_for(count, 256, [&](std::size_t i) {
    const std::size_t id = i * static_cast<std::size_t>(every);
    position_[i] = photons.position[id];
    normal_[i] = glm::normalize(photons.side[id].normal());
    const PhotonMap::Estimate found = map.measure(context, GatherPoint::irradiance(position_[i], normal_[i]));
    irradiance_[i] = found.radiance;
    radius_[i] = found.radius;
  });
  query_->build(position_);
}

std::optional<PhotonIrradiance::Found> PhotonIrradiance::at(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours nearest;
  for (const std::size_t k : {1, 8}) {
    query_->nearest(position, k, reach_, nearest);
    for (const Neighbour& n : nearest)
      if (glm::dot(normal_[n.id], normal) > 0.9f)
        return Found{irradiance_[n.id], std::max(radius_[n.id], std::sqrt(n.distance_squared))};
    if (nearest.size() < k) break;
  }
  return std::nullopt;
}

}  // namespace etendue
