#include "integrators/photons/photon_irradiance.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/photons/disc_moments.h"

#include <thread>

namespace etendue {

namespace {

// How far a sample point answers, in radii of its kernel.
constexpr float reach_where_even = 1, reach_where_uneven = 0.5f;
constexpr float too_uneven = 15;  // exceeded by one in a hundred discs of even light

}  // namespace

PhotonIrradiance::PhotonIrradiance(const PhotonMap& map, const Photons& sample_points, std::unique_ptr<PointQuery> query)
    : query_(std::move(query)),
      map_(map),
      position_(sample_points.size()),
      normal_(sample_points.size()),
      direction_(sample_points.size()),
      flown_(sample_points.size()),
      estimate_(sample_points.size()),
      reach_(sample_points.size()),
      state_(std::make_unique<std::atomic<State>[]>(sample_points.size())) {
  for (const std::uint16_t scatterings : map.photons().scatterings) longest_ = std::max<int>(longest_, scatterings);
  const std::vector<std::uint32_t> order = along_curve(sample_points.position);
  parallel_for(sample_points.size(), 256, [&](std::size_t i) {
    position_[i] = sample_points.position[order[i]];
    normal_[i] = glm::normalize(sample_points.side[order[i]].normal());
    direction_[i] = sample_points.direction[order[i]];
    flown_[i] = sample_points.flown[order[i]];
  });
  query_->build(position_);
}

float PhotonIrradiance::reach(const GatherPoint& at, float radius) const {
  DiscMoments moments(at.normal(), square(radius));
  map_.gather(at, radius, radius, [&](const GatheredPhoton& photon, const std::optional<Ray>&) {
    moments.add(photon.reflected, photon.offset, photon.distance_squared);
  });
  return (moments.unevenness() > too_uneven ? reach_where_uneven : reach_where_even) * radius;
}

const PhotonMap::Estimate& PhotonIrradiance::estimate(const RenderContext& context, std::uint32_t id) const {
  std::atomic<State>& state = state_[id];
  while (state.load(std::memory_order_acquire) != known) {
    State now = unknown;
    if (!state.compare_exchange_strong(now, under_way, std::memory_order_acquire)) {
      if (now == under_way) std::this_thread::yield();
      continue;
    }
    try {
      // On the photon's own way, which is free, and no farther off than kernels tell.
      const vec3 origin = position_[id] + std::min(0.01f * map_.radius(), 0.5f * flown_[id]) * direction_[id];
      const GatherPoint at = GatherPoint::irradiance(position_[id], normal_[id], origin);
      estimate_[id] = map_.measure(context, at);
      reach_[id] = reach(at, estimate_[id].radius);
    } catch (...) {
      state.store(unknown, std::memory_order_release);  // who waits for it tries by itself
      throw;
    }
    state.store(known, std::memory_order_release);
  }
  return estimate_[id];
}

std::optional<PhotonIrradiance::Found> PhotonIrradiance::at(const RenderContext& context, const vec3& position,
                                                            const vec3& normal, const vec3& origin) const {
  static thread_local Neighbours nearest;
  const float farthest = map_.radius();
  const NearWalls walls = map_.near_walls(position, normal, farthest);
  const auto sees = [&](const Neighbour& n) {
    if (walls.none()) return true;
    const auto end = [&] {
      return before_landing(position_[n.id], direction_[n.id], flown_[n.id], std::sqrt(n.distance_squared));
    };
    return !walls.may_hide(position_[n.id], end) || sees_landed(context, segment(origin, end()), position_[n.id]);
  };
  for (const std::size_t k : {1, 8}) {
    query_->nearest(position, k, farthest, nearest);
    for (const Neighbour& n : nearest)
      if (glm::dot(normal_[n.id], normal) > 0.9f && sees(n)) {
        const PhotonMap::Estimate& found = estimate(context, n.id);
        if (n.distance_squared > square(reach_[n.id])) continue;
        return Found{found.radiance, std::max(found.radius, std::sqrt(n.distance_squared)), found.photon_footprint};
      }
    if (nearest.size() < k) break;
  }
  return std::nullopt;
}

}  // namespace etendue
