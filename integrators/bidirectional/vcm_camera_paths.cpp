#include "integrators/bidirectional/vcm_camera_paths.h"

#include "integrators/paths/path.h"

namespace etendue {

void CameraPaths::trace(ivec2 pixel, std::uint32_t index, Rgb& radiance) {
  const auto key = pixel_index(pixel, context_.resolution);
  Sampler sampler(settings_.sampler, context_.seed, Stream::camera, key, index);
  SubPath path{.ray = sample_camera_ray(context_, pixel, sampler)};
  path.mis = MisPartials::at_camera(static_cast<float>(settings_.paths),
                                    context_.scene.camera.pdf(context_.resolution, path.ray.direction));
  trail_.vertices.clear();
  const auto lights = light_paths_.path(static_cast<std::uint32_t>(key % settings_.paths));
  for (int depth = 0;; ++depth) {
    const Hit hit = etendue::trace(context_, path.ray);
    if (!hit) {
      radiance += emitted_with_mis(path, hit, nullptr, depth);
      return;
    }
    const SurfacePoint point = context_.scene.surface_at(path.ray, hit);
    const float cos_in = std::abs(glm::dot(path.ray.direction, point.normal));
    path.mis.arrive(square(depth == 0 ? context_.scene.camera.spread(hit.t) : hit.t), cos_in);
    radiance += emitted_with_mis(path, hit, &point, depth);
    if (settings_.correlation) follow(path, hit.t, cos_in);
    if (depth >= settings_.max_depth || !settings_.connect) return;
    const Bsdf bsdf(context_.scene, point);
    if (bsdf.has_non_specular()) {
      const Vertex vertex{point, bsdf, -path.ray.direction, path, depth};
      next_event(vertex, sampler, radiance);
      for (const LightVertex& light : lights) {
        if (depth + 1 + light.events > settings_.max_depth) break;
        connect(vertex, light, radiance);
      }
      if (settings_.merge_radius > 0) merge(vertex, radiance);
    }
    if (!scatter(path, settings_, point, bsdf, sampler, depth, TransportMode::radiance, trail_.vertices)) return;
  }
}

void CameraPaths::follow(const SubPath& path, float distance, float cos_in) {
  std::vector<TrailVertex>& trail = trail_.vertices;
  if (!trail.empty()) {
    trail.push_back(trail.back().next(square(distance), cos_in));
    return;
  }
  trail_.first_distance_squared = square(distance);
  const Camera& camera = context_.scene.camera;
  trail.push_back({camera.pdf(context_.resolution, path.ray.direction) * cos_in / square(camera.spread(distance)), 0});
}

// Emission at the end of the path, after `depth` events; in full where it is seen directly, since no other strategy samples
// that.
Rgb CameraPaths::emitted_with_mis(const SubPath& path, const Hit& hit, const SurfacePoint* point, int depth) {
  const vec3& direction = path.ray.direction;
  const LightSampler& lights = context_.lights;
  const Rgb emitted = point ? lights.emitted(*point, -direction) : lights.environment(direction);
  if (depth == 0 || is_black(emitted)) return path.throughput * emitted;
  float direct, emission, to_area = 1;
  if (point) {
    const float cos_light = std::abs(glm::dot(direction, point->normal));
    to_area = 1 / square(hit.t);
    direct = lights.pdf(path.ray.origin, direction, *point) * cos_light * to_area;
    emission = lights.emission_pdf(point->light, point->normal, -direction, path.ray.origin);
  } else {
    direct = lights.environment_pdf(direction);
    emission = lights.emission_pdf(lights.environment_light(), {}, -direction, path.ray.origin);
  }
  if (settings_.correlation) {
    const TrailVertex& last = trail_.vertices.back();
    const float found = last.forward * to_area * (point ? std::abs(glm::dot(direction, point->normal)) : 1);
    densities_.connect({direct, found, point ? 2 : 1}, {}, trail_.vertices,
                       {0, emission * last.cos_out * to_area, 0, last.reverse, last.specular}, trail_.first_distance_squared);
    return path.throughput * emitted * densities_.hit();
  }
  // [Georgiev2012b] eq. 43.
  return path.throughput * emitted * mis_balance(0, direct * path.mis.vcm + emission * path.mis.vc);
}

void CameraPaths::next_event(const Vertex& v, Sampler& sampler, Rgb& radiance) {
  const vec2 u = sampler.get_2d();
  // From where the shadow ray starts, as in sample_direct_light.
  const auto light = context_.lights.sample(ray_origin(v.point, v.wo), u);
  if (!light) return;
  const vec3& wi = light->wi;
  const Rgb scattered = v.bsdf.evaluate(v.wo, wi);
  if (is_black(scattered) || is_black(light->radiance)) return;
  const float emission = context_.lights.emission_pdf_over_cosine(light->light, -wi, v.point.position);
  const bool point_light = light->delta && !std::isinf(light->distance);
  const float to_area = std::abs(glm::dot(wi, v.point.normal)) / (point_light ? square(light->distance) : 1);
  const float forward = light->delta ? 0 : v.bsdf.pdf(v.wo, wi), reverse = v.bsdf.pdf(wi, v.wo);
  float weight;
  if (settings_.correlation) {
    // All relative to the density of the direction: at an area light the way there makes the same factor everywhere.
    const bool area = !light->delta && !std::isinf(light->distance);
    const float d2 = area ? square(light->distance) : 1, cos_light = area ? std::abs(glm::dot(light->normal, wi)) : 1;
    densities_.connect({light->pdf_solid_angle * cos_light / d2, forward * cos_light / d2, area ? 2 : 1}, {}, trail_.vertices,
                       {0, emission * to_area * cos_light / d2, 0, reverse}, trail_.first_distance_squared);
    weight = densities_.connection(0);
  } else {
    // [Georgiev2012b] eq. 44, 45.
    weight = mis_balance(forward / light->pdf_solid_angle,
                         emission * to_area / light->pdf_solid_angle * v.path.mis.connected(settings_.mis_merge(), reverse));
  }
  gains_.push_back({&radiance, v.path.throughput * scattered * light->radiance * (weight / light->pdf_solid_angle)});
  shadow_rays_.push_back(shadow_ray(v.point, *light));
}

void CameraPaths::connect(const Vertex& v, const LightVertex& light, Rgb& radiance) {
  const vec3 towards = light.point.position - v.point.position;
  const float distance2 = length_squared(towards);
  if (!(distance2 > 0) || in_one_plane(v.point, light.point)) return;
  const float distance = std::sqrt(distance2);
  const vec3 wi = towards / distance;
  const Rgb camera_scattered = v.bsdf.evaluate(v.wo, wi);
  if (is_black(camera_scattered)) return;
  const Bsdf light_bsdf(context_.scene, light.point);
  const Rgb light_scattered = light_bsdf.evaluate(light.wo, -wi, TransportMode::importance);
  if (is_black(light_scattered)) return;
  // [Georgiev2012b] eq. 40, 41: the other strategies of the light's part, and of the camera's.
  const float camera_pdf_area = v.bsdf.pdf(v.wo, wi) * std::abs(glm::dot(wi, light.point.normal)) / distance2;
  const float light_pdf_area = light_bsdf.pdf(light.wo, -wi) * std::abs(glm::dot(wi, v.point.normal)) / distance2;
  const float light_reverse = light_bsdf.pdf(-wi, light.wo), camera_reverse = v.bsdf.pdf(wi, v.wo);
  float weight;
  if (settings_.correlation) {
    densities_.connect(light.trail->light, light.trail->part(light.events), trail_.vertices,
                       {camera_pdf_area, light_pdf_area, light_reverse, camera_reverse}, trail_.first_distance_squared);
    weight = densities_.connection(static_cast<std::size_t>(light.events));
  } else {
    const float merge = settings_.mis_merge();
    weight = mis_balance(camera_pdf_area * light.mis.connected(merge, light_reverse),
                         light_pdf_area * v.path.mis.connected(merge, camera_reverse));
  }
  gains_.push_back({&radiance, v.path.throughput * camera_scattered * light_scattered * light.power * (weight / distance2)});
  shadow_rays_.push_back(segment(v.point, light.point, wi));
}

void CameraPaths::merge(const Vertex& v, Rgb& radiance) {
  conditional_.clear();
  radiance += v.path.throughput * merges_.radiance(v.point, v.bsdf, v.wo, v.path.mis, v.depth, trail_, conditional_);
  for (const VcmMerges::Conditional& merge : conditional_) {
    gains_.push_back({&radiance, v.path.throughput * merge.radiance});
    shadow_rays_.push_back(merge.way);
  }
  constexpr std::size_t most_kept = 1 << 16;  // a wide radius finds thousands of them
  if (gains_.size() > most_kept) finish();
}

void CameraPaths::finish() {
  for_unoccluded(context_, shadow_rays_, [&](std::size_t i) { *gains_[i].radiance += gains_[i].value; });
  gains_.clear();
  shadow_rays_.clear();
}

}  // namespace etendue
