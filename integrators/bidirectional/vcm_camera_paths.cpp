#include "integrators/bidirectional/vcm_camera_paths.h"

#include "integrators/paths/path.h"

namespace etendue {

void VcmCameraPaths::trace(const Tile& tile, std::uint32_t index, std::span<Rgb> radiance) {
  static thread_local std::vector<CameraWalk> walks;
  static thread_local Wavefront<CameraWalk*> wave;
  static thread_local std::vector<PathSample> paths;
  camera_paths(context_, tile, settings_.sampler, index, paths);
  walks.clear();
  wave.clear();
  if (settings_.correlation) trails_.resize(paths.size());
  std::size_t next = 0;
  for_pixels(tile, [&](ivec2 pixel) {
    const PathSample& path = paths[next];
    const auto of_light = static_cast<std::uint32_t>(pixel_index(pixel, context_.resolution) % settings_.paths);
    walks.push_back({{}, path.sampler, light_paths_.path(of_light), light_bsdfs_.size(), &radiance[next], nullptr});
    for (const LightVertex& light : walks.back().lights) light_bsdfs_.emplace_back(context_.scene, light.point);
    walks.back().path.mis = MisPartials::at_camera(static_cast<float>(settings_.paths),
                                                   context_.scene.camera.pdf(context_.resolution, path.ray.direction));
    if (settings_.correlation) walks.back().trail = &trails_[next];
    ++next;
  });
  for (std::size_t i = 0; i < walks.size(); ++i) wave.start(&walks[i], paths[i].ray);
  wave.run(context_, 0,
           [&](CameraWalk* walk, Ray& ray, const SurfacePoint* met, int depth) { return meet(*walk, ray, met, depth); });
  finish();
}

bool VcmCameraPaths::meet(CameraWalk& walk, Ray& ray, const SurfacePoint* met, int depth) {
  SubPath& path = walk.path;
  if (!met) {
    *walk.radiance += emitted_with_mis(walk, ray, nullptr, depth);
    return false;
  }
  const SurfacePoint& point = *met;
  const float cos_in = std::abs(glm::dot(ray.direction, point.normal));
  path.mis.arrive(square(depth == 0 ? context_.scene.camera.spread(ray.t_max) : ray.t_max), cos_in);
  *walk.radiance += emitted_with_mis(walk, ray, met, depth);
  if (walk.trail) follow(*walk.trail, ray, depth, cos_in);
  if (depth >= settings_.max_depth || !settings_.connect) return false;
  const Bsdf bsdf(context_.scene, point);
  if (bsdf.has_non_specular()) {
    const Vertex vertex{point, bsdf, -ray.direction, walk, depth};
    next_event(vertex, walk.sampler);
    for (std::size_t i = 0; i < walk.lights.size(); ++i) {
      if (depth + 1 + walk.lights[i].events > settings_.max_depth) break;
      connect(vertex, walk.lights[i], light_bsdfs_[walk.light_bsdf + i]);
    }
    if (settings_.merge_radius > 0) merge(vertex);
  }
  return scatter(path, ray, settings_, point, bsdf, walk.sampler, depth, TransportMode::radiance,
                 walk.trail ? &walk.trail->vertices : nullptr);
}

void VcmCameraPaths::follow(CameraTrail& trail, const Ray& ray, int depth, float cos_in) const {
  const float distance = ray.t_max;
  if (depth > 0) {
    trail.vertices.push_back(trail.vertices.back().next(square(distance), cos_in));
    return;
  }
  trail.first_distance_squared = square(distance);
  const Camera& camera = context_.scene.camera;
  trail.vertices.assign(1, {camera.pdf(context_.resolution, ray.direction) * cos_in / square(camera.spread(distance)), 0});
}

// Emission at the end of the path, after `depth` events; in full where it is seen directly, since no other strategy samples
// that.
Rgb VcmCameraPaths::emitted_with_mis(const CameraWalk& walk, const Ray& ray, const SurfacePoint* point, int depth) {
  const SubPath& path = walk.path;
  const vec3& direction = ray.direction;
  const LightSampler& lights = context_.lights;
  const Rgb emitted = point ? lights.emitted(*point, -direction) : lights.environment(direction);
  if (depth == 0 || is_black(emitted)) return path.throughput * emitted;
  float direct, emission, to_area = 1;
  if (point) {
    const float cos_light = std::abs(glm::dot(direction, point->normal));
    to_area = 1 / square(ray.t_max);
    direct = lights.pdf(ray.origin, direction, *point) * cos_light * to_area;
    emission = lights.emission_pdf(point->light, point->normal, -direction, ray.origin);
  } else {
    direct = lights.environment_pdf(direction);
    emission = lights.emission_pdf(lights.environment_light(), {}, -direction, ray.origin);
  }
  if (settings_.correlation) {
    const TrailVertex& last = walk.trail->vertices.back();
    const float found = last.forward * to_area * (point ? std::abs(glm::dot(direction, point->normal)) : 1);
    densities_.connect({direct, found, point ? 2 : 1}, {}, walk.trail->vertices,
                       {0, emission * last.cos_out * to_area, 0, last.reverse, last.specular},
                       walk.trail->first_distance_squared);
    return path.throughput * emitted * densities_.hit();
  }
  // [Georgiev2012b] eq. 43.
  return path.throughput * emitted * mis_balance(0, direct * path.mis.vcm + emission * path.mis.vc);
}

void VcmCameraPaths::next_event(const Vertex& v, Sampler& sampler) {
  const vec2 u = sampler.get_2d();
  // From where the shadow ray starts, as in sample_direct_light.
  const auto light = context_.lights.sample(ray_origin(v.point, v.wo), u);
  if (!light) return;
  const vec3& wi = light->wi;
  const auto [scattered, pdf, reverse] = v.bsdf.pair(v.wo, wi);
  if (is_black(scattered) || is_black(light->radiance)) return;
  const float emission = context_.lights.emission_pdf_over_cosine(light->light, -wi, v.point.position);
  const bool point_light = light->delta && !std::isinf(light->distance);
  const float to_area = std::abs(glm::dot(wi, v.point.normal)) / (point_light ? square(light->distance) : 1);
  const float forward = light->delta ? 0 : pdf;
  float weight;
  if (settings_.correlation) {
    // All relative to the density of the direction: at an area light the way there makes the same factor everywhere.
    const bool area = !light->delta && !std::isinf(light->distance);
    const float d2 = area ? square(light->distance) : 1, cos_light = area ? std::abs(glm::dot(light->normal, wi)) : 1;
    densities_.connect({light->pdf_solid_angle * cos_light / d2, forward * cos_light / d2, area ? 2 : 1}, {},
                       v.walk.trail->vertices, {0, emission * to_area * cos_light / d2, 0, reverse},
                       v.walk.trail->first_distance_squared);
    weight = densities_.connection(0);
  } else {
    // [Georgiev2012b] eq. 44, 45.
    weight = mis_balance(forward / light->pdf_solid_angle, emission * to_area / light->pdf_solid_angle *
                                                               v.walk.path.mis.connected(settings_.mis_merge(), reverse));
  }
  gains_.push_back({v.walk.radiance, v.walk.path.throughput * scattered * light->radiance * (weight / light->pdf_solid_angle)});
  shadow_rays_.push_back(shadow_ray(v.point, *light));
}

void VcmCameraPaths::connect(const Vertex& v, const LightVertex& light, const Bsdf& light_bsdf) {
  const vec3 towards = light.point.position - v.point.position;
  const float distance2 = length_squared(towards);
  if (!(distance2 > 0) || in_one_plane(v.point, light.point)) return;
  const float distance = std::sqrt(distance2);
  const vec3 wi = towards / distance;
  const auto [camera_scattered, camera_forward, camera_reverse] = v.bsdf.pair(v.wo, wi);
  if (is_black(camera_scattered)) return;
  const auto [light_scattered, light_forward, light_reverse] = light_bsdf.pair(light.wo, -wi, TransportMode::importance);
  if (is_black(light_scattered)) return;
  // [Georgiev2012b] eq. 40, 41: the other strategies of the light's part, and of the camera's.
  const float camera_pdf_area = camera_forward * std::abs(glm::dot(wi, light.point.normal)) / distance2;
  const float light_pdf_area = light_forward * std::abs(glm::dot(wi, v.point.normal)) / distance2;
  float weight;
  if (settings_.correlation) {
    densities_.connect(light.trail->light, light.trail->part(light.events), v.walk.trail->vertices,
                       {camera_pdf_area, light_pdf_area, light_reverse, camera_reverse}, v.walk.trail->first_distance_squared);
    weight = densities_.connection(static_cast<std::size_t>(light.events));
  } else {
    const float merge = settings_.mis_merge();
    weight = mis_balance(camera_pdf_area * light.mis.connected(merge, light_reverse),
                         light_pdf_area * v.walk.path.mis.connected(merge, camera_reverse));
  }
  gains_.push_back(
      {v.walk.radiance, v.walk.path.throughput * camera_scattered * light_scattered * light.power * (weight / distance2)});
  shadow_rays_.push_back(segment(v.point, light.point, wi));
}

void VcmCameraPaths::merge(const Vertex& v) {
  static constexpr CameraTrail none;
  conditional_.clear();
  const SubPath& path = v.walk.path;
  Rgb& radiance = *v.walk.radiance;
  radiance += path.throughput *
              merges_.radiance(v.point, v.bsdf, v.wo, path.mis, v.depth, v.walk.trail ? *v.walk.trail : none, conditional_);
  for (const VcmMerges::Conditional& merge : conditional_) {
    gains_.push_back({&radiance, path.throughput * merge.radiance});
    shadow_rays_.push_back(merge.way);
  }
  constexpr std::size_t most_kept = 1 << 16;  // a wide radius finds thousands of them
  if (gains_.size() > most_kept) finish();
}

void VcmCameraPaths::finish() {
  for_unoccluded(context_, shadow_rays_, [&](std::size_t i) { *gains_[i].radiance += gains_[i].value; });
  gains_.clear();
  shadow_rays_.clear();
}

}  // namespace etendue
