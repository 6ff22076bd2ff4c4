#include "integrators/bidirectional/vcm_light_paths.h"

#include "framework/core/parallel.h"

#include <numeric>

namespace etendue {

namespace {

// A light path under way.
struct LightWalk {
  std::uint32_t number;  // in its chunk
  SubPath path;
  LightRay emitted;
  Sampler sampler;
};

}  // namespace

class LightPaths::Tracer {
 public:
  Tracer(const RenderContext& context, const VcmSettings& settings, bool keep, Chunk& chunk)
      : context_(context), settings_(settings), keep_(keep), chunk_(chunk) {
    densities_.count_strategies(static_cast<float>(settings.paths), settings.merge_area());
  }

  // `count` of them, from `first` on.
  void trace(std::uint64_t first, std::uint32_t count) {
    memory_.walks.clear();
    memory_.wave.clear();
    memory_.found.clear();
    for (std::uint32_t i = 0; i < count; ++i) emit(first + i, i);
    for (LightWalk& walk : memory_.walks) memory_.wave.start(&walk, walk.emitted.ray);
    etendue::count(Counter::photons_emitted, memory_.walks.size());
    if (settings_.max_depth > 0) trace_events();
    keep_in_order(count);
  }

 private:
  // A vertex that the lens can see.
  struct Splattable {
    LightWalk* walk;
    const SurfacePoint* point;
    Camera::Connection lens;
    vec3 wi;
    float distance;
  };
  // A splat that counts if nothing blocks its way.
  struct Candidate {
    Tracer* tracer;
    vec2 film;
    Rgb value;

    void arrive(const Ray& /*way*/) const { tracer->add_splats(film, value); }
  };
  struct Memory {
    std::vector<LightWalk> walks;
    Wavefront<LightWalk*, Candidate> wave;
    GrowingList<Found> found;  // event by event
    GrowingList<Splattable> splats;
    BsdfBatch splat_pairs;  // of the splats
    BsdfBatch onwards;      // of the paths that meet has not ended
  };
  static Memory& memory_of_thread() {
    static thread_local Memory memory;
    return memory;
  }

  // Light that falls on the film counts for each pixel whose filter reaches there.
  void add_splats(const vec2& film, const Rgb& value) {
    const ivec2 size = context_.resolution;
    const auto key = [&](int x, int y) { return static_cast<std::uint32_t>(y * size.x + x); };
    const PixelFilter* const filter = context_.scene.filter.get();
    if (filter == nullptr) {
      const ivec2 pixel(film);
      chunk_.splats.push_back({key(pixel.x, pixel.y), value});
      return;
    }
    const vec2 radius = filter->shape().radius;
    const ivec2 first = glm::max(ivec2(glm::floor(film - radius - 0.5f)), ivec2(0));
    const ivec2 last = glm::min(ivec2(glm::ceil(film + radius - 0.5f)), size - 1);
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x)
        if (const float density = filter->density(film - (vec2(x, y) + 0.5f)); density != 0)
          chunk_.splats.push_back({key(x, y), density * value});
  }

  void emit(std::uint64_t particle, std::uint32_t number) {
    Sampler sampler(settings_.sampler, context_.seed, Stream::light_path, particle >> 32, static_cast<std::uint32_t>(particle));
    const float u_light = context_.needs.light_choice ? sampler.get_1d() : 0;
    const vec2 u_position = sampler.get_2d();
    const auto emitted = context_.lights.emit(u_light, u_position, sampler.get_2d());
    if (!emitted || is_black(emitted->power) || !(emitted->pdf > 0)) return;
    const SubPath path{.throughput = emitted->power, .roulette = 1 / max_component(emitted->power)};
    memory_.walks.push_back({number, path, *emitted, sampler});
  }

  void trace_events() {
    const Scene& scene = context_.scene;
    const ReversibleSample* next = nullptr;
    int events = 0;
    memory_.wave.run(
        context_, 0,
        [&](LightWalk* walk, Ray& ray, const SurfacePoint* met, int depth) {
          events = depth + 1;
          return met != nullptr && meet(*walk, ray, *met, depth);
        },
        [&](LightSamples&) {
          const BsdfPair* pair = memory_.splat_pairs.pairs(scene, TransportMode::importance);
          for (const Splattable& splattable : memory_.splats) splat(splattable, *pair++, events);
          next = memory_.onwards.samples(scene, TransportMode::importance);
          memory_.splats.clear();
        },
        [&](LightWalk* walk, Ray& ray, std::size_t i, int depth) {
          LightTrail* const trail = trail_of(*walk);
          return scatter(walk->path, ray, settings_, memory_.onwards.point(i), next[i], walk->sampler, depth,
                         TransportMode::importance, trail ? &trail->vertices : nullptr);
        });
  }

  LightTrail* trail_of(const LightWalk& walk) { return settings_.correlation ? &chunk_.trails[walk.number] : nullptr; }

  bool meet(LightWalk& walk, Ray& ray, const SurfacePoint& point, int depth) {
    SubPath& path = walk.path;
    LightTrail* const trail = trail_of(walk);
    const vec3 wo = -ray.direction;
    if (meets_own_wall(ray, point)) return false;
    arrive(walk, ray, point, depth);
    if (trail) follow(*trail, walk, ray, point, depth);
    if (has_non_specular(context_.scene.materials[point.material])) {
      ask_splat(walk, wo, point);
      if (keep_) {
        auto& [number, vertex] = memory_.found.append();
        number = walk.number;
        vertex.point = point;
        vertex.wo = wo;
        vertex.flown = ray.t_max;
        vertex.power = path.throughput;
        vertex.mis = path.mis;
        vertex.events = depth + 1;
        vertex.opacity = context_.stopped_share(memory_.wave.hit_of(point));
        vertex.trail = trail;
      }
    }
    if (depth + 1 >= settings_.max_depth) return false;
    ask_direction(memory_.onwards, point, wo, walk.sampler);
    return true;
  }

  // Brings what was found event by event into the order of the paths.
  void keep_in_order(std::uint32_t count) {
    chunk_.path_end.assign(count, 0);
    for (const Found& found : memory_.found) ++chunk_.path_end[found.path];
    std::exclusive_scan(chunk_.path_end.begin(), chunk_.path_end.end(), chunk_.path_end.begin(), 0u);
    chunk_.vertices.resize(memory_.found.size());
    for (const Found& found : memory_.found) chunk_.vertices[chunk_.path_end[found.path]++] = found.vertex;
  }

  void arrive(LightWalk& walk, const Ray& ray, const SurfacePoint& point, int depth) const {
    if (!settings_.connect) return;
    auto& [number, path, emitted, sampler] = walk;
    const float cos_in = std::abs(glm::dot(ray.direction, point.normal)), distance = ray.t_max;
    if (depth > 0) return path.mis.arrive(square(distance), cos_in);
    const bool delta = emitted.delta_position || emitted.delta_direction;
    path.mis = MisPartials::at_light(emitted.pdf, context_.lights.direct_pdf(emitted, point.position),
                                     glm::dot(emitted.normal, emitted.ray.direction),
                                     emitted.delta_position ? square(distance) : 1, delta, settings_.mis_connect());
    path.mis.arrive(1, cos_in);
  }

  // Densities relative to those that at_light has: without the distance where the light is infinitely far.
  void follow(LightTrail& trail, const LightWalk& walk, const Ray& ray, const SurfacePoint& point, int depth) const {
    const float cos_in = std::abs(glm::dot(ray.direction, point.normal)), distance = ray.t_max;
    if (depth > 0) {
      trail.vertices.push_back(trail.vertices.back().next(square(distance), cos_in));
      return;
    }
    const LightRay& emitted = walk.emitted;
    const bool delta = emitted.delta_position || emitted.delta_direction;
    const bool area = std::holds_alternative<AreaLight>(context_.scene.lights[emitted.light]);
    const float d2 = area || emitted.delta_position ? square(distance) : 1;
    const float cos_light = glm::dot(emitted.normal, emitted.ray.direction);
    const float direct = context_.lights.direct_pdf(emitted, point.position) * cos_light / (area ? d2 : 1);
    trail.light = {direct, delta ? 0.0f : 1.0f, area ? 2 : 1};
    trail.vertices.assign(1, {emitted.pdf * cos_in / d2, cos_light / d2});
  }

  void ask_splat(LightWalk& walk, const vec3& wo, const SurfacePoint& point) {
    const vec2 lens = context_.needs.thin_lens ? walk.sampler.get_2d() : vec2(0.5f);
    const vec2 beyond = context_.scene.filter ? context_.scene.filter->shape().radius : vec2(0);
    const auto lens_point = context_.scene.camera.connect(context_.resolution, point.position, lens, beyond);
    if (!lens_point) return;
    const vec3 towards = lens_point->lens_point - point.position;
    const float distance = glm::length(towards);
    if (!(distance > 0)) return;
    const vec3 wi = towards / distance;
    Splattable& splattable = memory_.splats.append();
    splattable.walk = &walk;
    splattable.point = &point;
    splattable.lens = *lens_point;
    splattable.wi = wi;
    splattable.distance = distance;
    memory_.splat_pairs.ask(point, wo, wi);
  }

  // `events`: scattering events up to and with the vertex.
  void splat(const Splattable& splattable, const BsdfPair& pair, int events) {
    if (is_black(pair.value)) return;
    const auto& [walk, point, lens, wi, distance] = splattable;
    const SubPath& path = walk->path;
    const LightTrail* const trail = trail_of(*walk);
    const auto light_paths = static_cast<float>(settings_.paths);
    float weight = 1 / light_paths;
    if (settings_.connect) {
      // [Georgiev2012b] eq. 46, 47: the camera's density at the point, over the number of splats tried.
      const float pdf_camera_area = lens.importance * std::abs(glm::dot(wi, point->normal));
      if (trail) {
        densities_.connect(trail->light, trail->part(events), {}, {pdf_camera_area, 0, pair.pdf_reverse, 0}, square(distance));
        weight *= densities_.connection(static_cast<std::size_t>(events));
      } else {
        weight *= mis_balance(pdf_camera_area / light_paths * path.mis.connected(settings_.mis_merge(), pair.pdf_reverse), 0);
      }
    }
    memory_.wave.gain({this, lens.film, path.throughput * pair.value * (lens.importance * weight)},
                      segment(ray_origin(*point, wi), lens.lens_point));
  }

  const RenderContext& context_;
  const VcmSettings& settings_;
  bool keep_;
  Chunk& chunk_;
  Memory& memory_ = memory_of_thread();
  PathDensities densities_;
};

void LightPaths::trace(const RenderContext& context, const VcmSettings& settings, std::uint32_t iteration, bool keep) {
  chunks_.resize((settings.paths + chunk_size - 1) / chunk_size);
  parallel_for(chunks_.size(), 1, [&](std::size_t c) {
    Chunk& chunk = chunks_[c];
    chunk.splats.clear();
    if (settings.correlation) chunk.trails.resize(chunk_size);
    const auto first = static_cast<std::uint32_t>(c) * chunk_size;
    Tracer(context, settings, keep, chunk)
        .trace(static_cast<std::uint64_t>(iteration) * settings.paths + first, std::min(chunk_size, settings.paths - first));
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
