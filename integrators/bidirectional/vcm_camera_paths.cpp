#include "integrators/bidirectional/vcm_camera_paths.h"

#include "integrators/paths/path.h"

namespace etendue {

void VcmCameraPaths::trace(const Tile& tile, std::uint32_t index, std::span<Rgb> radiance) {
  auto& walks = memory_.walks;
  auto& wave = memory_.wave;
  auto& paths = memory_.paths;
  camera_paths(context_, tile, settings_.sampler, index, paths);
  walks.clear();
  wave.clear();
  if (settings_.correlation) memory_.trails.resize(paths.size());
  std::size_t number = 0;
  for_pixels(tile, [&](ivec2 pixel) {
    const PathSample& path = paths[number];
    const auto of_light = static_cast<std::uint32_t>(pixel_index(pixel, context_.resolution) % settings_.paths);
    CameraTrail* const trail = settings_.correlation ? &memory_.trails[number] : nullptr;
    walks.push_back({{}, path.sampler, light_paths_.path(of_light), &radiance[number], trail});
    walks.back().path.mis = MisPartials::at_camera(static_cast<float>(settings_.paths),
                                                   context_.scene.camera.pdf(context_.resolution, path.ray.direction));
    ++number;
  });
  for (std::size_t i = 0; i < walks.size(); ++i) wave.start(&walks[i], paths[i].ray);
  const ReversibleSample* next = nullptr;
  wave.run(
      context_, 0, [&](CameraWalk* walk, Ray& ray, const SurfacePoint* met, int depth) { return meet(*walk, ray, met, depth); },
      [&](LightSamples&) {
        join();
        next = memory_.onwards.samples(context_.scene, TransportMode::radiance);
      },
      [&](CameraWalk* walk, Ray& ray, std::size_t i, int depth) {
        return scatter(walk->path, ray, settings_, memory_.onwards.point(i), next[i], walk->sampler, depth,
                       TransportMode::radiance, walk->trail ? &walk->trail->vertices : nullptr);
      });
  finish();
}

void VcmCameraPaths::arrive(CameraWalk& walk, const Ray& ray, const SurfacePoint& point, int depth) {
  const float spread = depth == 0 ? context_.scene.camera.spread(ray.t_max) : ray.t_max;
  walk.path.mis.arrive(square(spread), std::abs(glm::dot(ray.direction, point.normal)));
  *walk.radiance += emitted_with_mis(walk, ray, &point, depth);
}

bool VcmCameraPaths::meet(CameraWalk& walk, Ray& ray, const SurfacePoint* met, int depth) {
  SubPath& path = walk.path;
  for_passed_lights(context_, ray, ray.t_max, [&](const SurfacePoint& light) {
    Ray to_light = ray;
    to_light.t_max = glm::length(light.position - ray.origin);
    const MisPartials before = path.mis;
    arrive(walk, to_light, light, depth);
    path.mis = before;  // the path goes on as if nothing were there
  });
  if (!met) {
    *walk.radiance += emitted_with_mis(walk, ray, nullptr, depth);
    return false;
  }
  const SurfacePoint& point = *met;
  const float cos_in = std::abs(glm::dot(ray.direction, point.normal));
  arrive(walk, ray, point, depth);
  if (walk.trail) follow(*walk.trail, ray, depth, cos_in);
  if (depth >= settings_.max_depth || !settings_.connect) return false;
  const vec3 wo = -ray.direction;
  if (has_non_specular(context_.scene.materials[point.material])) ask_joints(point, wo, walk, depth);
  ask_direction(memory_.onwards, point, wo, walk.sampler);
  return true;
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

void VcmCameraPaths::ask_joints(const SurfacePoint& point, const vec3& wo, CameraWalk& walk, int depth) {
  const bool light_sample = ask_light_sample(point, wo, walk.sampler);
  std::uint32_t connections = 0;
  for (const LightVertex& light : walk.lights) {
    if (depth + 1 + light.events > settings_.max_depth) break;
    if (ask_connection(point, wo, light)) ++connections;
  }
  Vertex& vertex = memory_.vertices.append();
  vertex.point = &point;
  vertex.wo = wo;
  vertex.walk = &walk;
  vertex.depth = depth;
  vertex.light_sample = light_sample;
  vertex.connections = connections;
}

bool VcmCameraPaths::ask_light_sample(const SurfacePoint& point, const vec3& wo, Sampler& sampler) {
  const vec2 u = sampler.get_2d();
  // The light is sampled from where the shadow ray starts, as in sample_direct_light.
  const auto light = context_.lights.sample(ray_origin(point, wo), u);
  if (!light || is_black(light->radiance)) return false;
  memory_.light_samples.push_back(*light);
  memory_.camera_ends.ask(point, wo, light->wi);
  return true;
}

bool VcmCameraPaths::ask_connection(const SurfacePoint& point, const vec3& wo, const LightVertex& light) {
  const vec3 towards = light.point.position - point.position;
  const float distance_squared = length_squared(towards);
  if (!(distance_squared > 0) || in_one_plane(point, light.point)) return false;
  const vec3 wi = towards / std::sqrt(distance_squared);
  Connection& connection = memory_.connections.append();
  connection.light = &light;
  connection.wi = wi;
  connection.distance_squared = distance_squared;
  memory_.camera_ends.ask(point, wo, wi);
  memory_.light_ends.ask(light.point, light.wo, -wi);
  return true;
}

// Joins the vertices of an event, one by one.
void VcmCameraPaths::join() {
  const BsdfPair* camera_end = memory_.camera_ends.pairs(context_.scene, TransportMode::radiance);
  const BsdfPair* light_end = memory_.light_ends.pairs(context_.scene, TransportMode::importance);
  auto light_sample = memory_.light_samples.begin();
  const Connection* connection = memory_.connections.begin();
  for (const Vertex& vertex : memory_.vertices) {
    if (vertex.light_sample) next_event(vertex, *light_sample++, *camera_end++);
    for (std::uint32_t i = 0; i < vertex.connections; ++i) connect(vertex, *connection++, *camera_end++, *light_end++);
    if (settings_.merge_radius > 0) merge(vertex);
  }
  memory_.vertices.clear();
  memory_.light_samples.clear();
  memory_.connections.clear();
}

// Adds what the path gains if nothing blocks the ray.
inline void VcmCameraPaths::gain(const CameraWalk& walk, const Rgb& value, const Ray& shadow_ray) {
  Gain& gain = memory_.gains.append();
  gain.radiance = walk.radiance;
  gain.value = value;
  Ray& ray = memory_.shadow_rays.append();
  ray.origin = shadow_ray.origin;
  ray.t_min = shadow_ray.t_min;
  ray.direction = shadow_ray.direction;
  ray.t_max = shadow_ray.t_max;
}

void VcmCameraPaths::next_event(const Vertex& v, const LightSample& light, const BsdfPair& pair) {
  const auto& [scattered, pdf, reverse] = pair;
  if (is_black(scattered)) return;
  const SurfacePoint& point = *v.point;
  const vec3& wi = light.wi;
  const float emission = context_.lights.emission_pdf_over_cosine(light.light, -wi, point.position);
  const bool point_light = light.delta && !std::isinf(light.distance);
  const float to_area = std::abs(glm::dot(wi, point.normal)) / (point_light ? square(light.distance) : 1);
  const float forward = light.delta ? 0 : pdf;
  float weight;
  if (settings_.correlation) {
    // All relative to the density of the direction: at an area light the way there makes the same factor everywhere.
    const bool area = !light.delta && !std::isinf(light.distance);
    const float d2 = area ? square(light.distance) : 1, cos_light = area ? std::abs(glm::dot(light.normal, wi)) : 1;
    densities_.connect({light.pdf_solid_angle * cos_light / d2, forward * cos_light / d2, area ? 2 : 1}, {},
                       v.walk->trail->vertices, {0, emission * to_area * cos_light / d2, 0, reverse},
                       v.walk->trail->first_distance_squared);
    weight = densities_.connection(0);
  } else {
    // [Georgiev2012b] eq. 44, 45.
    weight = mis_balance(forward / light.pdf_solid_angle, emission * to_area / light.pdf_solid_angle *
                                                              v.walk->path.mis.connected(settings_.mis_merge(), reverse));
  }
  gain(*v.walk, v.walk->path.throughput * scattered * light.radiance * (weight / light.pdf_solid_angle),
       shadow_ray(point, light));
}

void VcmCameraPaths::connect(const Vertex& v, const Connection& connection, const BsdfPair& camera_end,
                             const BsdfPair& light_end) {
  const auto& [camera_scattered, camera_forward, camera_reverse] = camera_end;
  const auto& [light_scattered, light_forward, light_reverse] = light_end;
  if (is_black(camera_scattered) || is_black(light_scattered)) return;
  const SurfacePoint& point = *v.point;
  const LightVertex& light = *connection.light;
  const vec3& wi = connection.wi;
  const float distance2 = connection.distance_squared;
  // [Georgiev2012b] eq. 40, 41: the other strategies of the light's part, and of the camera's.
  const float camera_pdf_area = camera_forward * std::abs(glm::dot(wi, light.point.normal)) / distance2;
  const float light_pdf_area = light_forward * std::abs(glm::dot(wi, point.normal)) / distance2;
  float weight;
  if (settings_.correlation) {
    densities_.connect(light.trail->light, light.trail->part(light.events), v.walk->trail->vertices,
                       {camera_pdf_area, light_pdf_area, light_reverse, camera_reverse}, v.walk->trail->first_distance_squared);
    weight = densities_.connection(static_cast<std::size_t>(light.events));
  } else {
    const float merge = settings_.mis_merge();
    weight = mis_balance(camera_pdf_area * light.mis.connected(merge, light_reverse),
                         light_pdf_area * v.walk->path.mis.connected(merge, camera_reverse));
  }
  gain(*v.walk, v.walk->path.throughput * camera_scattered * light_scattered * light.power * (weight / distance2),
       segment(point, light.point, wi));
}

void VcmCameraPaths::merge(const Vertex& v) {
  static constexpr CameraTrail none;
  const Bsdf bsdf(context_.scene, *v.point);
  memory_.conditional.clear();
  const SubPath& path = v.walk->path;
  *v.walk->radiance += path.throughput * merges_.radiance(*v.point, bsdf, v.wo, path.mis, v.depth,
                                                          v.walk->trail ? *v.walk->trail : none, memory_.conditional);
  for (const auto& [radiance, way, landed] : memory_.conditional)
    if (!context_.needs.masks)
      gain(*v.walk, path.throughput * radiance, way);
    else if (sees_landed(context_, way, landed))
      *v.walk->radiance += path.throughput * radiance;
  constexpr std::size_t most_kept = 1 << 16;  // a wide radius finds thousands of them
  if (memory_.gains.size() > most_kept) finish();
}

void VcmCameraPaths::finish() {
  for_unoccluded(context_, std::span{memory_.shadow_rays.data(), memory_.shadow_rays.size()},
                 [&](std::size_t i) { *memory_.gains[i].radiance += memory_.gains[i].value; });
  memory_.gains.clear();
  memory_.shadow_rays.clear();
}

}  // namespace etendue
