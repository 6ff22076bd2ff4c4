#include "integrators/bidirectional/vcm_merges.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/photons/photons.h"

namespace etendue {

namespace {

// Below this cosine the light's own foreshortening is not divided out again, lest a rounding error be.
constexpr float least_merged_cosine = 1e-3f;

}  // namespace

void VcmMerges::build(const RenderContext& context, const LightPaths& light_paths, const VcmSettings& settings,
                      const std::string& structure) {
  settings_ = settings;
  const std::vector<const LightVertex*> vertices = light_paths.vertices();
  std::vector<vec3> found(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) found[i] = vertices[i]->point.position;
  const std::vector<std::uint32_t> order = along_curve(found);
  positions_.resize(order.size());
  photons_.resize(order.size());
  followed_.resize(settings.correlation ? order.size() : 0);
  layers_.resize(context.needs.masks ? order.size() : 0);
  parallel_for(order.size(), 1024, [&](std::size_t i) {
    const LightVertex& v = *vertices[order[i]];
    positions_[i] = v.point.position;
    const float cosine = std::max(std::abs(glm::dot(v.wo, v.point.normal)), least_merged_cosine);
    photons_[i] = {v.wo, v.flown, v.power / (cosine * v.opacity), v.mis.vcm, v.mis.vm, v.events};
    if (!layers_.empty()) layers_[i] = v.point.layer;
    if (settings.correlation) followed_[i] = {v.trail->light, v.trail->part(v.events)};
  });
  query_ = context.make_points(structure);
  query_->build(positions_);
  if (settings.wall_test) walls_ = wall_grid(context.scene, settings.merge_radius, walls_);
  count(Counter::photons_stored, positions_.size());
}

Rgb VcmMerges::radiance(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const MisPartials& camera, int depth,
                        const CameraTrail& trail, std::vector<Conditional>& conditional) const {
  static thread_local Neighbours neighbours;
  query_->within(point.position, settings_.merge_radius, neighbours);
  count(Counter::photons_gathered, neighbours.size());
  const float connect = settings_.mis_connect();
  static thread_local PathDensities densities;
  densities.count_strategies(static_cast<float>(settings_.paths), settings_.merge_area());
  const vec3 normal = glm::dot(point.normal, wo) < 0 ? -point.normal : point.normal;
  const NearWalls walls = walls_ ? walls_->near(point.position, normal, settings_.merge_radius, false) : NearWalls();
  const float share = 1 / settings_.mis_merge();
  Rgb sum(0);
  for (const Neighbour& neighbour : neighbours) {
    const Photon& photon = photons_[neighbour.id];
    if (depth + photon.events > settings_.max_depth) continue;
    if (!layers_.empty() && !share_light(layers_[neighbour.id], point.layer)) continue;
    const auto [scattered, light_reverse, camera_reverse] = bsdf.pair(wo, photon.wo);
    if (is_black(scattered)) continue;
    float weight;
    if (settings_.correlation) {
      densities.merge(followed_[neighbour.id].light, followed_[neighbour.id].vertices, trail.vertices,
                      {0, 0, light_reverse, camera_reverse}, trail.first_distance_squared);
      weight = densities.merge_at(static_cast<std::size_t>(photon.events));
    } else {
      // [Georgiev2012b] eq. 38, 39.
      weight = mis_balance(photon.vcm * connect + photon.vm * light_reverse, camera.merged(connect, camera_reverse));
    }
    const Rgb merged = photon.power_over_cosine * scattered * (share * weight);
    const auto end = [&] {
      return before_landing(positions_[neighbour.id], photon.wo, photon.flown, std::sqrt(neighbour.distance_squared));
    };
    if (!walls.none() && (glm::dot(photon.wo, normal) < 0 || walls.may_hide(positions_[neighbour.id], end)))
      conditional.push_back({merged, segment(ray_origin(point, photon.wo), end()), positions_[neighbour.id]});
    else
      sum += merged;
  }
  return sum;
}

float VcmMerges::usual_distance(const RenderContext& context, const LightPaths& light_paths, std::span<const vec3> points,
                                std::size_t k, const std::string& structure) {
  const std::vector<const LightVertex*> vertices = light_paths.vertices();
  if (vertices.size() < k || points.empty()) return 0;
  std::vector<vec3> positions(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) positions[i] = vertices[i]->point.position;
  const auto query = context.make_points(structure);
  query->build(positions);
  std::vector<float> distances(points.size());
  parallel_for(points.size(), 8, [&](std::size_t i) {
    static thread_local Neighbours neighbours;
    query->nearest(points[i], k, infinity, neighbours);
    distances[i] = neighbours.back().distance_squared;
  });
  return std::sqrt(median(distances));
}

}  // namespace etendue
