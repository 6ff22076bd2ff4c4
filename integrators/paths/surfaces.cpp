#include "integrators/paths/surfaces.h"

namespace etendue {

void surfaces_at(const Scene& scene, std::span<const Ray> rays, std::span<const Hit> hits, std::vector<SurfacePoint>& points) {
  static thread_local std::vector<std::uint32_t> which;  // are on triangles of the world
  const bool far = scene.outgrows_caches();
  which.clear();
  if (points.size() < hits.size()) points.resize(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (far) scene.prefetch_surfaces(hits, i);
    if (!hits[i]) continue;
    if (hits[i].instance == 0 && scene.objects[0].geometry.is_triangle(hits[i].primitive))
      which.push_back(static_cast<std::uint32_t>(i));
    else
      points[i] = scene.surface_at(rays[i], hits[i]);
  }
  path_kernels().place({scene, which, rays.data(), hits.data(), points.data()});
}

void BsdfBatch::answer(const Scene& scene, TransportMode mode, std::vector<BsdfPair>* pairs,
                       std::vector<ReversibleSample>* samples) {
  begin();
  answered_ = true;
  if (pairs != nullptr && pairs->size() < queries_.size()) pairs->resize(queries_.size());
  if (samples != nullptr && samples->size() < queries_.size()) samples->resize(queries_.size());
  runs_.reset(scene.materials.size());
  for (std::size_t i = 0; i < queries_.size(); ++i) runs_.add(queries_[i].point->material, static_cast<std::uint32_t>(i));
  runs_.each([&](std::size_t material, std::span<const std::uint32_t> which) {
    path_kernels().ask[scene.materials[material].index()]({scene, contents_of(scene.materials[material]), mode, which,
                                                           queries_.data(), pairs != nullptr ? pairs->data() : nullptr,
                                                           samples != nullptr ? samples->data() : nullptr});
  });
}

void LightSamples::add(const SurfacePoint& point, const vec3& wo, const Rgb& throughput, PathSample& path) {
  states_.push_back({&path, throughput});
  rays_.push_back({.origin = point.position, .direction = -wo});
  points_.push_back(point);
}

std::size_t LightSamples::draw(const RenderContext& context, bool densities) {
  const Scene& scene = context.scene;
  const std::size_t count = states_.size();
  if (gains_.size() < count) {
    gains_.resize(count);
    shadow_rays_.resize(count);
  }
  if (densities && densities_.size() < count) densities_.resize(count);
  runs_.reset(scene.materials.size());
  for (std::size_t i = 0; i < count; ++i) runs_.add(points_[i].material, static_cast<std::uint32_t>(i));
  PathEvents events{.scene = scene,
                    .lights = context.lights,
                    .material = nullptr,
                    .mis = MisMode::light,
                    .scatters = false,
                    .roulette = false,
                    .first = false,
                    .on_triangles = false,
                    .which = {},
                    .states = states_.data(),
                    .rays = rays_.data(),
                    .hits = nullptr,
                    .points = points_.data(),
                    .gains = gains_.data(),
                    .shadow_rays = shadow_rays_.data(),
                    .densities = densities ? densities_.data() : nullptr,
                    .next_states = nullptr,
                    .next_rays = nullptr};
  runs_.each([&](std::size_t material, std::span<const std::uint32_t> which) {
    events.material = contents_of(scene.materials[material]);
    events.which = which;
    path_kernels().meet[scene.materials[material].index()](events);
  });
  states_.clear();
  rays_.clear();
  points_.clear();
  return events.gained;
}

}  // namespace etendue
