#include "integrators/path_space/hash_cache.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "framework/transport/roulette.h"
#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/cache_progress.h"
#include "integrators/path_space/path_space_grid.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/path.h"
#include "integrators/paths/path_choices.h"
#include "integrators/paths/wavefront.h"
#include "integrators/photons/cache_points.h"
#include "integrators/pilot/caustic_need.h"

#include <optional>
#include <utility>

namespace etendue {

namespace {

// A camera sample: the light it found itself, and its lookup in the cache.
struct Pixel {
  Sampler sampler;
  Rgb radiance{0};
  Rgb found{0};    // once the cache is asked: by the path since its last event was followed
  Rgb brought{0};  // indirect light at the surface the cache is asked about, by this path alone
  Rgb weight{0};   // of the cache's answer in the pixel; black: nothing is asked
  vec3 position{0}, normal{0};
  vec2 u{0};
  int depth = 0;
  bool follows = false;  // to its end, whatever cells have to say
};

// A diffuse surface that a path left in one direction. The values of events follow from the last back to the first:
// value(event) = arrived(next) + carried(next) value(next), or the light found up to the path's end.
struct Event {
  vec3 position, normal;
  int depth;
  std::uint32_t previous;
  Rgb carried;            // of this event's value to the one before: albedo, and all between the two
  Rgb carried_light;      // likewise of light that the direction meets, which is no part of the value
  Rgb arrived{0};         // to the event before, before this one's value: light between the two, and this one's direct light
  bool followed = false;  // the path met what is next, or nothing
};

struct HashedState {
  std::uint32_t pixel;
  Rgb throughput{1};  // to the camera; once the cache is asked, to the last event
  float eta_scale = 1, pdf_bsdf = 0;
  float followed = 1;  // the share of paths that follow such a direction
  bool asked = false, from_diffuse = false;
  CausticChain chain = {};
  std::uint32_t last_event = no_id;
};

struct TileWavefront {
  Wavefront<HashedState> paths;
  std::vector<Event> events;
  std::vector<std::uint32_t> last_events;  // of the pixels
};

// Says what a path does at a diffuse surface. Where it teaches, the event before has its value from the surface's cell, as if
// the path ended there, and the path goes on for that cell's sake.
enum class Onward { ends, teaches, follows };

class HashCache final : public Integrator, public FileCache {
 public:
  explicit HashCache(const HashCacheParams& params) : params_(params) {}

  void prepare(RenderContext& context) override {
    decide_caustic_map(context, params_, enough_hits_of_cells);
    context.choose_lights_by(params_.lights);
    max_depth_ = context.max_depth(params_.max_depth);
    {
      const auto timed = context.phases.measure("pilot");
      direct_ = choose_direct(context);
    }
    const ivec2 size = context.resolution;
    if (!grid_) make_grid(context);
    first_ = samples_;
    if (params_.caustic_map == CausticMap::on)
      caustics_ = std::make_unique<CausticLight>(context, params_.caustic_photons, max_depth_, params_.sampler);
    pixels_.resize(path_tile_count(size));
    values_.resize(pixels_.size());
    cached_ = CachedLight(size, context.states_error, PathSpaceGrid::forgetting, has_signed_filter(context));
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;

  Cache* cache() override { return this; }
  std::vector<RecordShape> record_shapes() const override { return grid_ ? grid_->cells() : std::vector<RecordShape>(); }
  Image standard_error() const override { return cached_.standard_error(); }

  Expectation expectation() const override {
    return {Bias::consistent, -2.0 / 3, 0.03,
            "indirect light blurred within cells, caustics within kernels, which shrink [Binder2018, Knaus2011]"};
  }

 private:
  // Format 2: sums in which older values weigh less; 3: their squared weights too; 4: of whole paths where depths are apart; 5:
  // without those on sheets that let light through.
  Identity identity() const override {
    return {"hash-cache", param_texts(params_), {"caustic_photons", "enough", "finest", "light_samples"}, 5};
  }
  CausticMap* caustic_map() override { return &params_.caustic_map; }
  void write(ByteWriter& body) const override {
    CHECK(grid_.has_value());
    body.add(samples_);
    grid_->write(body);
  }
  void read(const RenderContext& context, ByteReader& body) override;
  void make_grid(const RenderContext& context);
  void trace_tile(const RenderContext& context, std::size_t number, std::uint32_t sample);
  void add_tile(const RenderContext& context, std::size_t number, Film& film);
  // Depths that cells tell apart; that of a cell.
  static int depths(int max_depth) { return max_depth > shared_above ? 1 : std::max(max_depth, 1); }
  int key_depth(int depth) const { return max_depth_ > shared_above ? 0 : depth; }
  bool meet(const RenderContext& context, HashedState& state, Ray& ray, const SurfacePoint* met, int depth,
            std::vector<Pixel>& pixels, TileWavefront& wave) const;
  void meet_light(const RenderContext& context, const HashedState& state, const Ray& ray, const SurfacePoint* point,
                  Pixel& pixel, TileWavefront& wave) const;
  Onward onward(const HashedState& state, const vec3& position, const vec3& normal, const Rgb& albedo, int depth,
                Pixel& pixel) const;
  void leave_diffuse(HashedState& state, const vec3& position, const vec3& normal, const Rgb& albedo, int depth, Onward onward,
                     Pixel& pixel, TileWavefront& wave) const;

  HashCacheParams params_;
  int max_depth_ = 0;
  MisMode direct_ = MisMode::light;  // where no path goes on: by the limit of depth, or with trace_on = 0
  float traced_on_ = 0;              // of paths where they could end, in this iteration
  std::optional<PathSpaceGrid> grid_;
  std::unique_ptr<CausticLight> caustics_;        // null: paths meet lights behind specular surfaces by chance
  std::uint32_t samples_ = 0, first_ = 0;         // per pixel, that the grid knows; of them from a file
  std::vector<std::vector<Pixel>> pixels_;        // per tile
  std::vector<std::vector<CachedValue>> values_;  // likewise
  CachedLight cached_;
};

void HashCache::make_grid(const RenderContext& context) {
  const ivec2 size = context.resolution;
  const Camera& camera = context.scene.camera;
  const float pixel_angle = 2 * camera.half_extent(size).x / static_cast<float>(size.x);
  const vec3 eye = camera.ray(size, 0.5f * vec2(size), vec2(0.5f)).origin;
  grid_.emplace(context.bounds,
                PathSpaceGridOptions{eye, pixel_angle, params_.finest, params_.enough, camera.is_parallel()});
}

void HashCache::read(const RenderContext& context, ByteReader& body) {
  refuse_signed_filter(context, body);
  constexpr std::uint32_t most_samples = 1u << 30;  // so that adding iterations does not wrap
  if (body.take(samples_); samples_ > most_samples) body.refuse("more iterations than can be");
  make_grid(context);
  grid_->read(body, depths(context.max_depth(params_.max_depth)));
}

// Emission that a ray meets, MIS-weighted with the light sample at the ray's origin. For a ray from an event it is direct light
// of that surface, which is not part of the event's value.
void HashCache::meet_light(const RenderContext& context, const HashedState& state, const Ray& ray, const SurfacePoint* point,
                           Pixel& pixel, TileWavefront& wave) const {
  Rgb met(0);
  if (!state.chain.holds_emission())
    met = state.throughput * emitted_with_mis(context, ray, point, state.followed * state.pdf_bsdf) / state.followed;
  if (!state.from_diffuse) {
    (state.asked ? pixel.found : pixel.radiance) += met;
    return;
  }
  Event& event = wave.events[state.last_event];
  event.followed = true;
  if (event.previous == no_id) {
    pixel.radiance += pixel.weight * met;
  } else {
    event.arrived = pixel.found + event.carried_light * met;
    pixel.found = Rgb(0);
  }
}

// Beyond its lookup a path takes the value of a cell that has one; where each depth has cells of its own, of one cell only.
Onward HashCache::onward(const HashedState& state, const vec3& position, const vec3& normal, const Rgb& albedo, int depth,
                         Pixel& pixel) const {
  if (depth + 1 >= max_depth_ || is_black(state.throughput * albedo)) return Onward::ends;
  if (!state.asked || pixel.follows) return Onward::follows;
  const bool goes_on = pixel.sampler.get_1d() < traced_on_;
  count(Counter::lookups);
  const auto mean = grid_->mean(position, normal, key_depth(depth));
  if (!mean) return Onward::follows;
  pixel.found += state.throughput * albedo * *mean;
  pixel.follows = goes_on && max_depth_ <= shared_above;
  return goes_on ? Onward::teaches : Onward::ends;
}

// The first such surface of a path is where the cache will be looked up, once the paths of this sample are added.
void HashCache::leave_diffuse(HashedState& state, const vec3& position, const vec3& normal, const Rgb& albedo, int depth,
                              Onward onward, Pixel& pixel, TileWavefront& wave) const {
  if (!state.asked) {
    pixel.weight = state.throughput * albedo;
    pixel.position = position;
    pixel.normal = normal;
    pixel.u = pixel.sampler.get_2d();
    pixel.depth = key_depth(depth);
  }
  const Rgb carried_light = state.asked ? state.throughput * albedo : Rgb(1);
  const Rgb carried = onward == Onward::teaches ? Rgb(0) : carried_light;
  wave.events.push_back({position, normal, key_depth(depth), state.last_event, carried, carried_light});
  state.last_event = static_cast<std::uint32_t>(wave.events.size() - 1);
  state.asked = true;
}

// Handles what a ray meets and samples how the path continues; false where it ends.
bool HashCache::meet(const RenderContext& context, HashedState& state, Ray& ray, const SurfacePoint* met, int depth,
                     std::vector<Pixel>& pixels, TileWavefront& wave) const {
  Pixel& pixel = pixels[state.pixel];
  meet_light(context, state, ray, met, pixel, wave);
  if (!met || depth >= max_depth_) return false;
  const SurfacePoint& point = *met;
  const vec3 wo = -ray.direction, normal = towards(point.shading_normal, point.shading_normal, wo);
  const Bsdf bsdf(context.scene, point);
  const bool diffuse = bsdf.is_diffuse() && takes_records(point, wo);
  const Rgb albedo = diffuse ? bsdf.diffuse_albedo() : Rgb(1);
  const Onward next = diffuse ? onward(state, point.position, normal, albedo, depth, pixel) : Onward::follows;
  const float followed = next == Onward::follows ? 1 : depth + 1 >= max_depth_ ? 0 : std::min(traced_on_, 1.0f);
  Rgb& found = state.asked ? pixel.found : pixel.radiance;
  if (caustics_ && caustics_->gathers_at(point.material))
    found += state.throughput * caustics_->reflected(context, point, bsdf, wo, depth);
  const int samples = diffuse && !state.asked ? params_.light_samples : 1;
  for (int i = 0; i < samples; ++i) {
    // Where none follows a direction, met_by_bsdf below is the BSDF sample of each.
    const MisMode mode = followed > 0 ? MisMode::power : direct_;
    if (const auto light = sample_direct_light(context, point, bsdf, wo, pixel.sampler, mode, 0, followed > 0 ? followed : 1))
      wave.paths.gain({&found, state.throughput * light->radiance / static_cast<float>(samples)}, light->shadow_ray);
  }
  if (followed == 0 && direct_ == MisMode::power)
    found += state.throughput * met_by_bsdf(context, point, bsdf, wo, pixel.sampler);
  if (next == Onward::ends) return false;
  // Roulette goes by the weight of this event's value in that of the event before, once there is one: the weight in the pixel
  // says nothing about that in the cell.
  float worth = max_component(state.throughput * albedo) * state.eta_scale;
  if (diffuse) {
    leave_diffuse(state, point.position, normal, albedo, depth, next, pixel, wave);
    state.throughput = Rgb(1);
    state.eta_scale = 1;
  }
  const float u_lobe = pixel.sampler.get_1d();
  const BsdfSample scattered = bsdf.sample(wo, u_lobe, pixel.sampler.get_2d());
  if (!scattered) return false;
  state.chain.leave(caustics_.get(), point.material, scattered.specular, scattered.pdf_solid_angle);
  // A diffuse surface's albedo is counted already.
  if (!diffuse) {
    state.throughput *= scattered.weight;
    if (scattered.transmitted) state.eta_scale *= scattered.eta * scattered.eta;
    worth = max_component(state.throughput) * state.eta_scale;
  }
  state.from_diffuse = diffuse;
  state.followed = diffuse ? followed : 1;
  state.pdf_bsdf = scattered.pdf_solid_angle;
  ray = spawn_ray(point, scattered.wi);
  if (depth + 1 < params_.roulette_depth) return true;
  return survives_roulette(state.throughput, std::min(0.95f, worth), pixel.sampler);
}

// Computes the value of each event.
void collect(std::vector<Pixel>& pixels, TileWavefront& wave, std::vector<CachedValue>& values) {
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    Rgb value = pixels[p].found;
    for (std::uint32_t i = wave.last_events[p]; i != no_id; i = wave.events[i].previous) {
      Event& event = wave.events[i];
      if (!event.followed) event.arrived = std::exchange(value, Rgb(0));
      if (is_finite(value)) values.push_back({event.position, event.normal, event.depth, value});
      value = event.arrived + event.carried * value;
    }
    pixels[p].brought = value;
  }
}

// Traces the camera paths of a tile, without what the cache will answer.
void HashCache::trace_tile(const RenderContext& context, std::size_t number, std::uint32_t sample) {
  static thread_local TileWavefront wave;  // for its memory
  std::vector<Pixel>& pixels = pixels_[number];
  pixels.clear();
  wave.paths.clear();
  wave.events.clear();
  for_pixels(path_tile(context.resolution, number), [&](ivec2 pixel) {
    const PathSample path = camera_path(context, pixel, params_.sampler, sample);
    wave.paths.start({static_cast<std::uint32_t>(pixels.size())}, path.ray);
    pixels.push_back({path.sampler});
  });
  wave.last_events.assign(pixels.size(), no_id);
  wave.paths.run(context, 0, [&](HashedState& state, Ray& ray, const SurfacePoint* met, int depth) {
    const bool goes_on = meet(context, state, ray, met, depth, pixels, wave);
    wave.last_events[state.pixel] = state.last_event;
    return goes_on;
  });
  values_[number].clear();
  collect(pixels, wave, values_[number]);
}

// Adds the tile's pixels to the film, each with the cache's answer where it asks for one.
void HashCache::add_tile(const RenderContext& context, std::size_t number, Film& film) {
  auto next = pixels_[number].begin();
  for_pixels(path_tile(context.resolution, number), [&](ivec2 at) {
    const Pixel& pixel = *next++;
    Rgb cached(0);
    CachedError error;
    if (!is_black(pixel.weight)) {
      count(Counter::lookups);
      cached = pixel.weight * grid_->smooth_mean(pixel.position, pixel.normal, pixel.depth, pixel.u).value_or(pixel.brought);
      if (context.states_error) error = grid_->error(pixel.position, pixel.normal, pixel.depth, pixel.u, pixel.weight);
    }
    const float weight = sample_weight(context, at, samples_ - 1);
    cached_.add(film, at, weight * pixel.radiance, weight * cached, error, weight);
  });
}

void HashCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t sample = first_ + index;
  if (caustics_) caustics_->trace(context, sample);
  grid_->begin(sample);
  traced_on_ = params_.trace_on * std::max(1.0f, grid_->scatter());
  {
    const auto timed = context.phases.measure("trace");
    parallel_for(pixels_.size(), 1, [&](std::size_t number) { trace_tile(context, number, sample); });
  }
  {
    const auto timed = context.phases.measure("learn");
    grid_->add(values_);
    samples_ = sample + 1;
  }
  const auto timed = context.phases.measure("gather");
  cached_.begin(index, sample + 1.0);  // lookups rest on a nearly constant share of the paths so far (path_space_grid.h)
  parallel_for(pixels_.size(), 1, [&](std::size_t number) { add_tile(context, number, film); });
}

}  // namespace

IntegratorEntry hash_cache_entry() {
  return integrator_entry<HashCache, HashCacheParams>("hash-cache", "path-space filtering through a hash grid", 700);
}

}  // namespace etendue
