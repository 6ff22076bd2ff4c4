#include "integrators/hash_cache.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "integrators/cache_points.h"
#include "integrators/cache_progress.h"
#include "integrators/emission.h"
#include "integrators/file_cache.h"
#include "integrators/path.h"
#include "integrators/path_space_grid.h"
#include "integrators/wavefront.h"

#include <optional>

namespace etendue {

namespace {

constexpr int tile = 16;
constexpr std::uint32_t none = no_id;

// A camera sample: what it found itself, and what it asks the cache for.
struct Pixel {
  Sampler sampler;
  Rgb radiance{0};
  Rgb brought{0};  // indirect light at the surface the cache is asked about, by this path alone
  Rgb weight{0};   // of the cache's answer in the pixel; black: nothing is asked
  vec3 position{0}, normal{0};
  vec2 u{0};
  int depth = 0;
};

// A diffuse surface that a path left by one direction.
struct Event {
  vec3 position, normal;
  int depth;
  std::uint32_t previous;
  Rgb throughput;        // of what the path brings here; after the event
  Rgb before{infinity};  // what it had brought home when it met what is next; infinite: nothing is next
};

struct Walk {
  std::uint32_t pixel;
  Rgb throughput{1};  // to the camera; once the cache is asked, to the surface that it is asked about
  float eta_scale = 1, pdf_bsdf = 0;
  bool asked = false, from_diffuse = false;  // from_diffuse: the light sample there has had all emission
  std::uint32_t last_event = none;
};

struct TileWavefront {
  Wavefront<Walk> paths;
  std::vector<Event> events;
  std::vector<std::uint32_t> last_events;  // of the pixels
};

class HashCache final : public Integrator, public FileCache {
 public:
  explicit HashCache(const HashCacheParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override {
    max_depth_ = context.max_depth(params_.max_depth);
    const ivec2 size = context.resolution;
    if (!grid_) make_grid(context);
    first_ = samples_;
    const ivec2 tiles = (size + tile - 1) / tile;
    pixels_.resize(static_cast<std::size_t>(tiles.x) * tiles.y);
    values_.resize(pixels_.size());
    cached_ = CachedLight(size, context.states_error);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;

  SavableCache* savable_cache() override { return this; }
  std::optional<std::vector<RecordShape>> record_shapes() const override {
    return grid_ ? grid_->cells() : std::vector<RecordShape>();
  }
  std::optional<Image> standard_error() const override { return cached_.standard_error(); }

  Expectation expectation() const override {
    return {Bias::consistent, -2.0 / 3, 0.03, "indirect light blurred within cells, which shrink [Binder2018]"};
  }

 private:
  Identity identity() const override { return {"hash-cache", param_texts(params_), {"enough", "finest", "light_samples"}}; }
  void write(ByteWriter& body) const override {
    CHECK(grid_.has_value());
    body.add(samples_);
    grid_->write(body);
  }
  void read(const RenderContext& context, ByteReader& body) override;
  void make_grid(const RenderContext& context);
  Tile tile_of(std::size_t number, ivec2 resolution) const {
    const int across = (resolution.x + tile - 1) / tile;
    const ivec2 begin = tile * ivec2(static_cast<int>(number) % across, static_cast<int>(number) / across);
    return {begin, glm::min(begin + tile, resolution)};
  }
  // Depths that cells tell apart; that of a cell.
  static int depths(int max_depth) { return max_depth > shared_above ? 1 : std::max(max_depth, 1); }
  int key_depth(int depth) const { return max_depth_ > shared_above ? 0 : depth; }
  bool meet(const RenderContext& context, Walk& walk, Ray& ray, const Hit& hit, int depth, std::vector<Pixel>& pixels,
            TileWavefront& wave) const;
  bool leave_diffuse(Walk& walk, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, Pixel& pixel,
                     TileWavefront& wave) const;

  HashCacheParams params_;
  SamplerKind sampler_;
  int max_depth_ = 0;
  std::optional<PathSpaceGrid> grid_;
  std::uint32_t samples_ = 0, first_ = 0;         // per pixel, that the grid knows; of them from a file
  std::vector<std::vector<Pixel>> pixels_;        // per tile
  std::vector<std::vector<CachedValue>> values_;  // likewise
  CachedLight cached_;
};

void HashCache::make_grid(const RenderContext& context) {
  const ivec2 size = context.resolution;
  const float pixel_angle = 2 * context.scene.camera.half_extent(size).x / static_cast<float>(size.x);
  const vec3 eye = context.scene.camera.ray(size, 0.5f * vec2(size), vec2(0.5f)).origin;
  grid_.emplace(context.scene.bounds(), PathSpaceGridOptions{eye, pixel_angle, params_.finest, params_.enough});
}

void HashCache::read(const RenderContext& context, ByteReader& body) {
  constexpr std::uint32_t most_samples = 1u << 30;  // so that adding iterations does not wrap
  if (body.take(samples_); samples_ > most_samples) body.refuse("more iterations than can be");
  make_grid(context);
  grid_->read(body, depths(context.max_depth(params_.max_depth)));
}

// At a diffuse surface: asks the cache, or has it asked once this sample's paths are in. False where the path ends.
bool HashCache::leave_diffuse(Walk& walk, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, Pixel& pixel,
                              TileWavefront& wave) const {
  if (depth + 1 >= max_depth_) return false;
  const vec3 normal = towards(point.shading_normal, point.shading_normal, wo);
  const Rgb albedo = bsdf.diffuse_albedo();
  const vec2 u = pixel.sampler.get_2d();
  const float u_on = pixel.sampler.get_1d();
  if (!walk.asked) {
    pixel.weight = walk.throughput * albedo;
    pixel.position = point.position;
    pixel.normal = normal;
    pixel.u = u;
    pixel.depth = key_depth(depth);
    walk.asked = true;
    walk.throughput = Rgb(1);
    if (is_black(pixel.weight)) return false;
  } else {
    walk.throughput *= albedo;
    if (is_black(walk.throughput)) return false;
    if (u_on >= params_.trace_on) {
      count(Counter::lookups);
      if (const auto mean = grid_->mean(point.position, normal, key_depth(depth))) {
        pixel.brought += walk.throughput * *mean;
        return false;
      }
    }
  }
  wave.events.push_back({point.position, normal, key_depth(depth), walk.last_event, walk.throughput});
  walk.last_event = static_cast<std::uint32_t>(wave.events.size() - 1);
  return true;
}

// What a ray finds, and where the path goes from there; false where it ends.
bool HashCache::meet(const RenderContext& context, Walk& walk, Ray& ray, const Hit& hit, int depth, std::vector<Pixel>& pixels,
                     TileWavefront& wave) const {
  Pixel& pixel = pixels[walk.pixel];
  Rgb& radiance = walk.asked ? pixel.brought : pixel.radiance;
  if (walk.from_diffuse) wave.events[walk.last_event].before = pixel.brought;
  if (!hit) {
    if (!walk.from_diffuse) radiance += walk.throughput * met_emission(context, ray, nullptr, walk.pdf_bsdf);
    return false;
  }
  const SurfacePoint point = context.scene.surface_at(ray, hit);
  if (!walk.from_diffuse) radiance += walk.throughput * met_emission(context, ray, &point, walk.pdf_bsdf);
  if (depth >= max_depth_) return false;
  const vec3 wo = -ray.direction;
  const Bsdf bsdf(context.scene, point);
  const bool diffuse = bsdf.is_diffuse();
  const int samples = diffuse && !walk.asked ? params_.light_samples : 1;
  for (int i = 0; i < samples; ++i)
    if (const auto light =
            sample_direct_light(context, point, bsdf, wo, pixel.sampler, diffuse ? MisMode::light : MisMode::power))
      wave.paths.gain(radiance, walk.throughput * light->radiance / static_cast<float>(samples), light->shadow_ray);
  if (diffuse && !leave_diffuse(walk, point, bsdf, wo, depth, pixel, wave)) return false;
  const float u_lobe = pixel.sampler.get_1d();
  const BsdfSample scattered = bsdf.sample(wo, u_lobe, pixel.sampler.get_2d());
  if (!scattered) return false;
  // A diffuse surface's albedo is in its throughput already.
  if (!diffuse) walk.throughput *= scattered.weight;
  walk.from_diffuse = diffuse;
  if (scattered.transmitted) walk.eta_scale *= scattered.eta * scattered.eta;
  walk.pdf_bsdf = scattered.pdf_solid_angle;
  ray = spawn_ray(point, scattered.wi);
  if (depth + 1 < params_.roulette_depth) return true;
  const float survival = std::min(0.95f, max_component(walk.throughput) * walk.eta_scale);
  if (!(pixel.sampler.get_1d() < survival)) return false;
  walk.throughput /= survival;
  return true;
}

// What each event's direction brought, over what the event carried. A channel that carried nothing tells nothing.
void collect(const std::vector<Pixel>& pixels, const TileWavefront& wave, std::vector<CachedValue>& values) {
  for (std::size_t p = 0; p < pixels.size(); ++p)
    for (std::uint32_t i = wave.last_events[p]; i != none; i = wave.events[i].previous) {
      const Event& event = wave.events[i];
      if (!(event.throughput.x > 0 && event.throughput.y > 0 && event.throughput.z > 0)) continue;
      const Rgb value = glm::max(pixels[p].brought - event.before, Rgb(0)) / event.throughput;
      if (is_finite(value)) values.push_back({event.position, event.normal, event.depth, value});
    }
}

void HashCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t sample = first_ + index;
  grid_->begin(sample);
  {
    const auto timed = context.phases.measure("trace");
    parallel_for(pixels_.size(), 1, [&](std::size_t t) {
      static thread_local TileWavefront wave;  // for its memory
      std::vector<Pixel>& pixels = pixels_[t];
      pixels.clear();
      wave.paths.clear();
      wave.events.clear();
      for_pixels(tile_of(t, context.resolution), [&](ivec2 pixel) {
        const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
        Sampler sampler(sampler_, context.seed, Stream::camera, key, sample);
        const Ray ray = sample_camera_ray(context, pixel, sampler);
        wave.paths.start({static_cast<std::uint32_t>(pixels.size())}, ray);
        pixels.push_back({sampler});
      });
      wave.last_events.assign(pixels.size(), none);
      wave.paths.run(context, 0, [&](Walk& walk, Ray& ray, const Hit& hit, int depth) {
        const bool goes_on = meet(context, walk, ray, hit, depth, pixels, wave);
        wave.last_events[walk.pixel] = walk.last_event;
        return goes_on;
      });
      values_[t].clear();
      collect(pixels, wave, values_[t]);
    });
  }
  {
    const auto timed = context.phases.measure("learn");
    grid_->add(values_);
    samples_ = sample + 1;
  }
  const auto timed = context.phases.measure("gather");
  cached_.begin(index, sample + 1.0);  // what the cache adds rests on all paths so far
  parallel_for(pixels_.size(), 1, [&](std::size_t t) {
    auto next = pixels_[t].begin();
    for_pixels(tile_of(t, context.resolution), [&](ivec2 at) {
      const Pixel& pixel = *next++;
      Rgb cached(0);
      float error = 0;
      if (!is_black(pixel.weight)) {
        count(Counter::lookups);
        cached = pixel.weight * grid_->smooth_mean(pixel.position, pixel.normal, pixel.depth, pixel.u).value_or(pixel.brought);
        if (context.states_error) error = grid_->standard_error(pixel.position, pixel.normal, pixel.depth, pixel.weight);
      }
      cached_.add(film, at, pixel.radiance, cached, error);
    });
  });
}

}  // namespace

IntegratorEntry hash_cache_entry() {
  return {"hash-cache", "path-space filtering through a hash grid", list_params<HashCacheParams>(),
          [](const ParamMap& map) { return std::make_unique<HashCache>(read_params<HashCacheParams>(map, "hash-cache")); }};
}

}  // namespace etendue
