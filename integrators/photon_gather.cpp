#include "integrators/photon_gather.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"

namespace etendue {

KernelDisc find_disc(const PointQuery& query, const vec3& position, int k, float radius, Neighbours& out) {
  if (k == 0) {
    query.within(position, radius, out);
    return {out.size(), radius * radius};
  }
  query.nearest(position, static_cast<std::size_t>(k), radius, out);
  if (out.size() < static_cast<std::size_t>(k)) return {out.size(), radius * radius};
  return {out.size() - 1, out.back().distance_squared};
}

void PhotonMap::build(Photons photons, std::unique_ptr<PointQuery> query, const GatherOptions& options) {
  query_ = std::move(query);
  photons_ = photons.reordered(along_curve(photons.position));
  options_ = options;
  query_->build(photons_.position);
  radius_ = options.radius > 0 ? options.radius : automatic_radius();
}

// The median distance at which photons have k photons about them (50 for a fixed radius); as a bound for the search four times
// that, which only regions with a sixteenth of the usual density reach.
float PhotonMap::automatic_radius() const {
  constexpr std::size_t probes = 256;
  if (photons_.empty()) return 1;
  const auto k = std::min<std::size_t>(options_.k > 0 ? options_.k : 50, photons_.size());
  std::vector<float> distances(std::min(probes, photons_.size()));
  parallel_for(distances.size(), 8, [&](std::size_t i) {
    static thread_local Neighbours neighbours;
    query_->nearest(photons_.position[i * photons_.size() / distances.size()], k, infinity, neighbours);
    distances[i] = std::sqrt(neighbours.back().distance_squared);
  });
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::max(*middle, std::numeric_limits<float>::min()) * (options_.k > 0 ? 4 : 1);
}

Rgb PhotonMap::radiance(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, PhotonHistory histories,
                        int max_scatterings) const {
  if (photons_.empty() || max_scatterings < 0) return Rgb(0);
  static thread_local Neighbours neighbours;
  const KernelDisc disc = find_disc(*query_, point.position, options_.k, radius_, neighbours);
  count(Counter::photons_gathered, disc.count);
  if (!(disc.radius_squared > 0)) return Rgb(0);

  // Corners and the far side of thin walls fail the side test; a side is the same up to 84 degrees, so that curved surfaces
  // pass. Where the BSDF is evaluated, it refuses light from behind unless the surface lets it through.
  const vec3 normal = glm::dot(wo, point.normal) < 0 ? -point.normal : point.normal;
  const bool constant = bsdf.is_diffuse() && point.shading_normal == point.normal;
  const auto longest = static_cast<std::uint16_t>(std::min(max_scatterings, 65535));
  Rgb sum(0);
  for (std::size_t i = 0; i < disc.count; ++i) {
    const auto [id, distance_squared] = neighbours[i];
    const PhotonSide side = photons_.side[id];
    if (!(side.history & histories) || photons_.scatterings[id] > longest) continue;
    if (options_.side_test) {
      const float facing = glm::dot(side.normal(), normal);
      if ((constant ? facing : std::abs(facing)) < 0.1f) continue;
    }
    const Rgb power = photons_.power[id] * disc.shape(options_.kernel, distance_squared);
    if (constant) {
      sum += power;
    } else {
      // The photons' own cosine is the geometric one; `evaluate` has the shading one, as path tracing does.
      const vec3& wi = photons_.direction[id];
      sum += power * bsdf.evaluate(wo, wi) / std::max(std::abs(glm::dot(wi, normal)), 0.02f);
    }
  }
  return sum * disc.per_area() * (constant ? bsdf.diffuse_albedo() * inv_pi : Rgb(1));
}

}  // namespace etendue
