#include "integrators/bidirectional/vcm_light_paths.h"

#include "framework/core/parallel.h"

namespace etendue {

class LightPaths::Tracer {
 public:
  Tracer(const RenderContext& context, const VcmSettings& settings, bool keep, Chunk& chunk)
      : context_(context), settings_(settings), keep_(keep), chunk_(chunk) {
    densities_.count_strategies(static_cast<float>(settings.paths), settings.merge_area());
  }

  void trace(std::uint64_t particle) {
    Sampler sampler(settings_.sampler, context_.seed, Stream::light_path, particle >> 32, static_cast<std::uint32_t>(particle));
    walk(sampler);
    chunk_.path_end.push_back(static_cast<std::uint32_t>(chunk_.vertices.size()));
  }

  // The splats that nothing blocks.
  void finish() {
    for_unoccluded(context_, chunk_.lens_rays, [&](std::size_t i) { add_splats(chunk_.candidates[i]); });
    chunk_.lens_rays.clear();
    chunk_.candidates.clear();
  }

 private:
  // Light that falls on the film counts for each pixel whose filter reaches there.
  void add_splats(const Candidate& candidate) {
    const ivec2 size = context_.resolution;
    const auto key = [&](int x, int y) { return static_cast<std::uint32_t>(y * size.x + x); };
    const PixelFilter* const filter = context_.scene.filter.get();
    if (filter == nullptr) {
      const ivec2 pixel(candidate.film);
      chunk_.splats.push_back({key(pixel.x, pixel.y), candidate.value});
      return;
    }
    const vec2 radius = filter->shape().radius;
    const ivec2 first = glm::max(ivec2(glm::floor(candidate.film - radius - 0.5f)), ivec2(0));
    const ivec2 last = glm::min(ivec2(glm::ceil(candidate.film + radius - 0.5f)), size - 1);
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x)
        if (const float density = filter->density(candidate.film - (vec2(x, y) + 0.5f)); density != 0)
          chunk_.splats.push_back({key(x, y), density * candidate.value});
  }

  void walk(Sampler& sampler) {
    const float u_light = context_.needs.light_choice ? sampler.get_1d() : 0;
    const vec2 u_position = sampler.get_2d();
    const auto emitted = context_.lights.emit(u_light, u_position, sampler.get_2d());
    if (!emitted || is_black(emitted->power) || !(emitted->pdf > 0)) return;
    count(Counter::photons_emitted);
    SubPath path{.ray = emitted->ray, .throughput = emitted->power, .roulette = 1 / max_component(emitted->power)};
    for (int depth = 0; depth < settings_.max_depth; ++depth) {
      const Hit hit = etendue::trace(context_, path.ray);
      if (!hit) return;
      const SurfacePoint point = context_.scene.surface_at(path.ray, hit);
      arrive(path, *emitted, point, hit.t, depth);
      if (settings_.correlation) follow(path, *emitted, point, hit.t, depth);
      const Bsdf bsdf(context_.scene, point);
      if (bsdf.has_non_specular()) {
        splat(path, point, bsdf, sampler, depth);
        const LightTrail* const trail = settings_.correlation ? &chunk_.trails.back() : nullptr;
        if (keep_) chunk_.vertices.push_back({point, -path.ray.direction, hit.t, path.throughput, path.mis, depth + 1, trail});
      }
      if (depth + 1 >= settings_.max_depth ||
          !scatter(path, settings_, point, bsdf, sampler, depth, TransportMode::importance, chunk_.trail))
        return;
    }
  }

  void arrive(SubPath& path, const LightRay& emitted, const SurfacePoint& point, float distance, int depth) const {
    if (!settings_.connect) return;
    const float cos_in = std::abs(glm::dot(path.ray.direction, point.normal));
    if (depth > 0) return path.mis.arrive(square(distance), cos_in);
    const bool delta = emitted.delta_position || emitted.delta_direction;
    path.mis = MisPartials::at_light(emitted.pdf, context_.lights.direct_pdf(emitted, point.position),
                                     glm::dot(emitted.normal, emitted.ray.direction),
                                     emitted.delta_position ? square(distance) : 1, delta, settings_.mis_connect());
    path.mis.arrive(1, cos_in);
  }

  // Densities relative to those that at_light has: without the distance where the light is infinitely far.
  void follow(const SubPath& path, const LightRay& emitted, const SurfacePoint& point, float distance, int depth) {
    const float cos_in = std::abs(glm::dot(path.ray.direction, point.normal));
    if (depth > 0) {
      chunk_.trail.push_back(chunk_.trail.back().next(square(distance), cos_in));
      return;
    }
    const bool delta = emitted.delta_position || emitted.delta_direction;
    const bool area = std::holds_alternative<AreaLight>(context_.scene.lights[emitted.light]);
    const float d2 = area || emitted.delta_position ? square(distance) : 1;
    const float cos_light = glm::dot(emitted.normal, emitted.ray.direction);
    const float direct = context_.lights.direct_pdf(emitted, point.position) * cos_light / (area ? d2 : 1);
    chunk_.trails.push_back({{direct, delta ? 0.0f : 1.0f, area ? 2 : 1}, &chunk_.trail, chunk_.trail.size()});
    chunk_.trail.push_back({emitted.pdf * cos_in / d2, cos_light / d2});
  }

  void splat(const SubPath& path, const SurfacePoint& point, const Bsdf& bsdf, Sampler& sampler, int depth) {
    const vec2 lens = context_.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
    const vec2 beyond = context_.scene.filter ? context_.scene.filter->shape().radius : vec2(0);
    const auto lens_point = context_.scene.camera.connect(context_.resolution, point.position, lens, beyond);
    if (!lens_point) return;
    const vec3 towards = lens_point->lens_point - point.position, wo = -path.ray.direction;
    const float distance = glm::length(towards);
    const vec3 wi = towards / distance;
    const Rgb scattered = bsdf.evaluate(wo, wi, TransportMode::importance);
    if (is_black(scattered) || !(distance > 0)) return;
    const auto light_paths = static_cast<float>(settings_.paths);
    float weight = 1 / light_paths;
    if (settings_.connect) {
      // [Georgiev2012b] eq. 46, 47: the camera's density at the point, over the number of splats tried.
      const float pdf_camera_area = lens_point->importance * std::abs(glm::dot(wi, point.normal));
      const float reverse = bsdf.pdf(wi, wo);
      if (settings_.correlation) {
        const LightTrail& trail = chunk_.trails.back();
        densities_.connect(trail.light, trail.part(depth + 1), {}, {pdf_camera_area, 0, reverse, 0}, square(distance));
        weight *= densities_.connection(static_cast<std::size_t>(depth) + 1);
      } else {
        weight *= mis_balance(pdf_camera_area / light_paths * path.mis.connected(settings_.mis_merge(), reverse), 0);
      }
    }
    chunk_.candidates.push_back({lens_point->film, path.throughput * scattered * (lens_point->importance * weight)});
    chunk_.lens_rays.push_back(segment(ray_origin(point, wi), lens_point->lens_point));
  }

  const RenderContext& context_;
  const VcmSettings& settings_;
  bool keep_;
  Chunk& chunk_;
  PathDensities densities_;
};

void LightPaths::trace(const RenderContext& context, const VcmSettings& settings, std::uint32_t iteration, bool keep) {
  chunks_.resize((settings.paths + chunk_size - 1) / chunk_size);
  parallel_for(chunks_.size(), 1, [&](std::size_t c) {
    Chunk& chunk = chunks_[c];
    chunk.vertices.clear();
    chunk.path_end.clear();
    chunk.splats.clear();
    chunk.trails.clear();
    chunk.trail.clear();
    if (settings.correlation) chunk.trails.reserve(chunk_size);  // pointed to
    Tracer tracer(context, settings, keep, chunk);
    const auto first = static_cast<std::uint32_t>(c) * chunk_size, end = std::min(settings.paths, first + chunk_size);
    for (std::uint32_t i = first; i < end; ++i) tracer.trace(static_cast<std::uint64_t>(iteration) * settings.paths + i);
    tracer.finish();
  });
}

std::span<const LightVertex> LightPaths::path(std::uint32_t index) const {
  const Chunk& chunk = chunks_[index / chunk_size];
  const std::uint32_t i = index % chunk_size, begin = i == 0 ? 0 : chunk.path_end[i - 1];
  return std::span(chunk.vertices).subspan(begin, chunk.path_end[i] - begin);
}

std::vector<const LightVertex*> LightPaths::vertices() const {
  std::size_t count = 0;
  for (const Chunk& chunk : chunks_) count += chunk.vertices.size();
  std::vector<const LightVertex*> all;
  all.reserve(count);
  for (const Chunk& chunk : chunks_)
    for (const LightVertex& vertex : chunk.vertices) all.push_back(&vertex);
  return all;
}

void LightPaths::add_splats(std::span<dvec3> pixels) const {
  for (const Chunk& chunk : chunks_)
    for (const Splat& splat : chunk.splats) pixels[splat.pixel] += dvec3(splat.value);
}

}  // namespace etendue
