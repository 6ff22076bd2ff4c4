#include "integrators/photon_irradiance.h"

#include "framework/core/parallel.h"

namespace etendue {

PhotonIrradiance::PhotonIrradiance(const RenderContext& context, const PhotonMap& map, const Photons& places,
                                   std::unique_ptr<PointQuery> query)
    : query_(std::move(query)),
      position_(places.size()),
      normal_(places.size()),
      irradiance_(places.size()),
      radius_(places.size()),
      grain_(places.size()),
      reach_(map.radius()) {
  for (const std::uint16_t scatterings : map.photons().scatterings) longest_ = std::max<int>(longest_, scatterings);
  const std::vector<std::uint32_t> order = along_curve(places.position);
  parallel_for(places.size(), 256, [&](std::size_t i) {
    position_[i] = places.position[order[i]];
    normal_[i] = glm::normalize(places.side[order[i]].normal());
    const PhotonMap::Estimate found = map.measure(context, GatherPoint::irradiance(position_[i], normal_[i]));
    irradiance_[i] = found.radiance;
    radius_[i] = found.radius;
    grain_[i] = found.grain;
  });
  query_->build(position_);
}

std::optional<PhotonIrradiance::Found> PhotonIrradiance::at(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours nearest;
  for (const std::size_t k : {1, 8}) {
    query_->nearest(position, k, reach_, nearest);
    for (const Neighbour& n : nearest)
      if (glm::dot(normal_[n.id], normal) > 0.9f)
        return Found{irradiance_[n.id], std::max(radius_[n.id], std::sqrt(n.distance_squared)), grain_[n.id]};
    if (nearest.size() < k) break;
  }
  return std::nullopt;
}

}  // namespace etendue
