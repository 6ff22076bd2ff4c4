#include "integrators/photons/photon_irradiance.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"

namespace etendue {

PhotonIrradiance::PhotonIrradiance(const RenderContext& context, const PhotonMap& map, const Photons& sample_points,
                                   std::unique_ptr<PointQuery> query)
    : query_(std::move(query)),
      map_(map),
      position_(sample_points.size()),
      normal_(sample_points.size()),
      direction_(sample_points.size()),
      irradiance_(sample_points.size()),
      radius_(sample_points.size()),
      photon_footprint_(sample_points.size()),
      flown_(sample_points.size()) {
  for (const std::uint16_t scatterings : map.photons().scatterings) longest_ = std::max<int>(longest_, scatterings);
  const std::vector<std::uint32_t> order = along_curve(sample_points.position);
  parallel_for(sample_points.size(), 256, [&](std::size_t i) {
    position_[i] = sample_points.position[order[i]];
    normal_[i] = glm::normalize(sample_points.side[order[i]].normal());
    direction_[i] = sample_points.direction[order[i]];
    flown_[i] = sample_points.flown[order[i]];
    // On the photon's own way, which is free, and no farther off than kernels tell.
    const vec3 origin = position_[i] + std::min(0.01f * map.radius(), 0.5f * flown_[i]) * direction_[i];
    const PhotonMap::Estimate found = map.measure(context, GatherPoint::irradiance(position_[i], normal_[i], origin));
    irradiance_[i] = found.radiance;
    radius_[i] = found.radius;
    photon_footprint_[i] = found.photon_footprint;
  });
  query_->build(position_);
}

std::optional<PhotonIrradiance::Found> PhotonIrradiance::at(const RenderContext& context, const vec3& position,
                                                            const vec3& normal, const vec3& origin) const {
  static thread_local Neighbours nearest;
  const float reach = map_.radius();
  const NearWalls walls = map_.near_walls(position, normal, reach);
  const auto sees = [&](const Neighbour& n) {
    if (walls.none()) return true;
    const auto end = [&] {
      return before_landing(position_[n.id], direction_[n.id], flown_[n.id], std::sqrt(n.distance_squared));
    };
    return !walls.may_hide(position_[n.id], end) || unoccluded(context, segment(origin, end()));
  };
  for (const std::size_t k : {1, 8}) {
    query_->nearest(position, k, reach, nearest);
    for (const Neighbour& n : nearest)
      if (glm::dot(normal_[n.id], normal) > 0.9f && sees(n))
        return Found{irradiance_[n.id], std::max(radius_[n.id], std::sqrt(n.distance_squared)), photon_footprint_[n.id]};
    if (nearest.size() < k) break;
  }
  return std::nullopt;
}

}  // namespace etendue
