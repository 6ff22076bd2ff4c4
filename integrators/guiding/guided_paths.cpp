#include "integrators/guiding/guided_paths.h"
#include "framework/transport/roulette.h"

#include "integrators/paths/emission.h"
#include "integrators/paths/wavefront.h"

namespace etendue {

namespace {

constexpr float least_survival = 0.1f;  // so that an error of the cache costs little
constexpr float roulette_slack = 3;     // roulette begins where a path is worth a third of what it promised

// An event of a path, kept until the radiance that it found is known.
struct GuidedEvent {
  GuideRecord record;  // but its radiance
  Rgb throughput;      // after the event, before roulette
  std::uint32_t previous;
  Rgb before{infinity};  // radiance of the path when it met what is next; infinite: it met nothing
  float cached = -1;     // luminance from the cache, of indirect light scattered by what it met; < 0: none
};

struct GuidedState {
  PathSample* path;
  Rgb throughput{1};
  Rgb unguided{1};            // what BSDF sampling would have made of it
  float expected_light = -1;  // luminance of indirect light that the path was expected to find at its first diffuse surface
  float eta_scale = 1;        // undoes the eta^2 of refractions
  float pdf = 0;              // of the ray's direction; 0: delta lobe or camera
  std::uint32_t last_event = no_id;
};

// The mixture with which a path's light sample is MIS-weighted.
struct MixtureOfPath {
  float share;  // of the BSDF
  const DirectionDensity* directions;
};

struct GuidedWavefront {
  Wavefront<GuidedState> paths;
  std::vector<GuidedEvent> events;
  std::vector<std::uint32_t> last_events;  // of the paths
  std::vector<MixtureOfPath> mixtures;     // of the paths
};

// The mixture at a point: the BSDF alone where it has delta lobes only, or nothing was learnt.
struct Mixture {
  const Bsdf& bsdf;
  const SdTree& tree;
  vec3 normal;  // on the side the path comes from
  std::uint32_t leaf;
  const Guide& guide;
  float share;

  Mixture(const Bsdf& b, const SdTree& t, const SurfacePoint& point, const vec3& wo)
      : bsdf(b),
        tree(t),
        normal(glm::dot(point.shading_normal, wo) < 0 ? -point.shading_normal : point.shading_normal),
        leaf(t.leaf(point.position, normal)),
        guide(t.guide(leaf)),
        share(b.has_non_specular() ? guide.bsdf_share(b.is_diffuse()) : 1) {}
};

struct MixtureSample {
  BsdfSample sample;  // weight and density of the mixture
  Rgb value{0};       // f |cos|; black for delta lobes
  Rgb unguided{0};    // the weight that BSDF sampling gives
  vec2 square{0};     // of the direction
  float pdf_bsdf = 0, pdf_guide = 0;
};

// Index beyond over index before for a direction that crosses the surface.
float crossed_eta(const RenderContext& context, const SurfacePoint& point, const vec3& wo) {
  const auto* dielectric = std::get_if<Dielectric>(&context.scene.materials[point.material]);
  if (!dielectric || dielectric->thin) return 1;
  return glm::dot(wo, point.normal) > 0 ? dielectric->eta : 1 / dielectric->eta;
}

MixtureSample sample_mixture(const RenderContext& context, const SurfacePoint& point, const Mixture& mixture, const vec3& wo,
                             Sampler& sampler) {
  const float u_choice = sampler.get_1d();
  const vec2 u = sampler.get_2d();
  MixtureSample out;
  BsdfSample& sample = out.sample;
  if (u_choice < mixture.share) {
    sample = mixture.bsdf.sample(wo, std::min(u_choice / mixture.share, 0x1.fffffep-1f), u);
    out.unguided = sample.weight;
    if (!sample || sample.specular) {
      sample.weight /= mixture.share;
      return out;
    }
    out.pdf_bsdf = sample.pdf_solid_angle;
    out.value = sample.weight * sample.pdf_solid_angle;
    out.square = square_from_direction(sample.wi);
    if (mixture.share < 1) out.pdf_guide = mixture.guide.directions().density(out.square) / (4 * pi);
  } else {
    const auto drawn = mixture.guide.directions().sample(u);
    sample.wi = glm::normalize(direction_from_square(drawn.square));
    out.square = drawn.square;
    out.value = mixture.bsdf.evaluate(wo, sample.wi);
    if (is_black(out.value)) return out;
    out.pdf_guide = drawn.density / (4 * pi);
    out.pdf_bsdf = mixture.bsdf.pdf(wo, sample.wi);
    out.unguided = out.pdf_bsdf > 0 ? out.value / out.pdf_bsdf : Rgb(1);
    sample.transmitted = glm::dot(wo, point.normal) * glm::dot(sample.wi, point.normal) < 0;
    if (sample.transmitted) sample.eta = crossed_eta(context, point, wo);
  }
  sample.pdf_solid_angle = mixed_pdf(mixture.share, out.pdf_bsdf, out.pdf_guide);
  sample.weight = out.value / sample.pdf_solid_angle;
  return out;
}

// The weight of a light sample whose shadow ray is free.
float light_weight(const LightDensities& densities, const MixtureOfPath& mixture, const Ray& shadow_ray, MisMode mis) {
  if (!(densities.light > 0)) return 1;
  const float pdf_guide = mixture.share < 1 ? mixture.directions->pdf_solid_angle(glm::normalize(shadow_ray.direction)) : 0;
  return mis_weight(mis, densities.light, mixed_pdf(mixture.share, densities.bsdf, pdf_guide));
}

// Survival probability: the light that the cache expects the path to find from here, over the light it was expected to find at
// its first diffuse surface; where the cache knows nothing, the throughput of BSDF sampling.
float survival(GuidedState& state, float expected) {
  if (!(state.expected_light > 0)) return survival_of(state.unguided, state.eta_scale);
  return expected < 0 ? 1 : std::clamp(roulette_slack * expected / state.expected_light, least_survival, 1.0f);
}

// Samples the direction in which a path continues; false where it ends.
bool scatter(const RenderContext& context, GuidedState& state, Ray& ray, const SurfacePoint& point, const Mixture& mixture,
             int depth, const PathSettings& settings, std::vector<GuidedEvent>& events) {
  const vec3 wo = -ray.direction;
  float expected = -1;
  if (mixture.bsdf.is_diffuse() && mixture.guide.indirect() >= 0) {
    expected = luminance(state.throughput * mixture.bsdf.diffuse_albedo()) * mixture.guide.indirect();
    if (state.expected_light < 0) state.expected_light = expected;
  }
  const MixtureSample scattered = sample_mixture(context, point, mixture, wo, state.path->sampler);
  const BsdfSample& sample = scattered.sample;
  state.throughput *= sample.weight;
  if (!sample.specular && mixture.bsdf.has_non_specular()) {
    events.push_back({{.leaf = mixture.tree.leaf_to_teach(mixture.leaf, point.position, mixture.normal, scattered.square),
                       .square = scattered.square,
                       .cosine = std::abs(glm::dot(sample.wi, mixture.normal)),
                       .radiance = 0,
                       .gathered = 0,
                       .scattered = luminance(scattered.value),
                       .albedo = luminance(mixture.bsdf.diffuse_albedo()),
                       .pdf = sample ? sample.pdf_solid_angle : 1,
                       .pdf_bsdf = scattered.pdf_bsdf,
                       .pdf_guide = scattered.pdf_guide},
                      state.throughput,
                      state.last_event});
    state.last_event = static_cast<std::uint32_t>(events.size() - 1);
  }
  if (!sample) return false;
  state.unguided *= glm::min(scattered.unguided, vec3(1));
  if (sample.transmitted) state.eta_scale *= sample.eta * sample.eta;
  state.pdf = sample.pdf_solid_angle;
  ray = spawn_ray(point, sample.wi);
  if (depth + 1 < settings.roulette_depth) return true;
  const float survives = survival(state, expected);
  if (!survives_roulette(state.throughput, survives, state.path->sampler)) return false;
  state.unguided /= survives;
  return true;
}

// Makes a record of each event: the radiance that the path gained after it, over its throughput there. Where the next surface
// is in the cache, its indirect light is taken from the cache and only the rest from the path.
void record(const PathSample& path, std::uint32_t last, const std::vector<GuidedEvent>& events,
            std::vector<GuideRecord>& records) {
  const std::size_t begin = records.size();
  Rgb until = path.radiance;  // of the path when it left the next event
  for (std::uint32_t i = last; i != no_id; i = events[i].previous) {
    const GuidedEvent& event = events[i];
    const auto since = [&](const Rgb& radiance) {
      Rgb gained(0);
      for (int c = 0; c < 3; ++c)
        if (event.throughput[c] > 0) gained[c] = std::max(0.0f, radiance[c] - event.before[c]) / event.throughput[c];
      return luminance(gained);
    };
    GuideRecord record = event.record;
    record.gathered = since(path.radiance);
    record.radiance = event.cached < 0 ? record.gathered : since(until) + event.cached;
    records.push_back(record);
    if (event.before.x != infinity) until = event.before;
  }
  std::reverse(records.begin() + static_cast<std::ptrdiff_t>(begin), records.end());
}

// Stores with the event before what the cache knows of the surface that the path has reached.
void ask_cache(GuidedState& state, const Mixture& mixture, std::vector<GuidedEvent>& events) {
  if (state.last_event == no_id || !mixture.bsdf.is_diffuse()) return;
  GuidedEvent& event = events[state.last_event];
  if (event.cached >= 0 || mixture.guide.indirect() < 0) return;
  Rgb carried(0);
  for (int c = 0; c < 3; ++c)
    if (event.throughput[c] > 0) carried[c] = state.throughput[c] / event.throughput[c];
  event.cached = mixture.guide.indirect() * luminance(carried * mixture.bsdf.diffuse_albedo());
}

}  // namespace

void trace_guided_paths(const RenderContext& context, std::span<PathSample> paths, const PathSettings& settings,
                        const SdTree& guide, std::vector<GuideRecord>& records) {
  static thread_local GuidedWavefront wave;  // for its memory
  Wavefront<GuidedState>& states = wave.paths;
  std::vector<GuidedEvent>& events = wave.events;
  std::vector<std::uint32_t>& last_events = wave.last_events;
  states.clear();
  events.clear();
  last_events.assign(paths.size(), no_id);
  wave.mixtures.resize(paths.size());
  for (PathSample& path : paths) states.start({&path}, path.ray);
  const auto meet = [&](GuidedState& state, Ray& ray, const SurfacePoint* met, int depth) {
    PathSample& path = *state.path;
    if (state.pdf != 0) events[state.last_event].before = path.radiance;
    path.radiance += emitted_with_mis(context, ray, met, state.pdf, state.throughput, settings.mis);
    if (!met || depth >= settings.max_depth) return false;
    const SurfacePoint& point = *met;
    const Bsdf bsdf(context.scene, point);
    const Mixture mixture(bsdf, guide, point, -ray.direction);
    ask_cache(state, mixture, events);
    const auto number = static_cast<std::size_t>(&path - paths.data());
    if (bsdf.has_non_specular()) {
      states.light_samples().add(point, -ray.direction, state.throughput, path);
      wave.mixtures[number] = {mixture.share, &mixture.guide.directions()};
    }
    const bool goes_on = scatter(context, state, ray, point, mixture, depth, settings, events);
    last_events[number] = state.last_event;
    return goes_on;
  };
  states.run(context, 0, meet, [&](LightSamples& lights) {
    lights.trace(context, [&](const PathGain& gain, const LightDensities& densities, const Ray& shadow_ray) {
      const MixtureOfPath& mixture = wave.mixtures[static_cast<std::size_t>(densities.path - paths.data())];
      *gain.to += gain.radiance * light_weight(densities, mixture, shadow_ray, settings.mis);
    });
  });
  for (std::size_t i = 0; i < paths.size(); ++i) record(paths[i], last_events[i], events, records);
}

}  // namespace etendue
