// A path's event at a surface: direct light by one light sample, then a direction in which the path goes on.
//
// Written over lanes (framework/core/lanes.h): one path, or one in each lane, all at surfaces of one material. trace_paths
// (path.h) sorts the paths of a wave so; integrators/lanes/ compiles this for each instruction set.
#pragma once

#include "framework/scene/triangle_surface.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/direct_light.h"
#include "framework/transport/light_lanes.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/paths/bsdf_event.h"
#include "integrators/paths/hemisphere_strata.h"
#include "integrators/paths/path.h"

namespace etendue {

// A path under way: what it takes along to its next hit.
struct PathState {
  PathSample* path;
  Rgb throughput{1};
  float eta_scale = 1;  // undoes the eta^2 of refractions, which roulette must not take for absorption
  float pdf_bsdf = 0;   // of the direction the ray was sampled with; 0: delta lobe or camera
};

// Light that is gained if its shadow ray is free.
struct PathGain {
  Rgb* to;
  Rgb radiance;
  void arrive(const Ray&) const { *to += radiance; }
};

// The densities, over solid angle, of the direction of a path's light sample.
struct LightDensities {
  const PathSample* path;
  float light;  // with which the light sample found it; 0: a light that no ray can hit
  float bsdf;
};

// Paths of a wave that meet one material: what there is of them, and where it goes. Counts grow from what they are.
struct PathEvents {
  const Scene& scene;
  const LightSampler& lights;
  const void* material;  // of the kind that the function is for
  MisMode mis;
  bool scatters;  // else direct light alone is wanted
  bool roulette;
  float evenness = 1;  // as PathSettings
  bool first;          // PathSample::first_normal is wanted
  bool on_triangles;   // of the world; else `points` has the surfaces
  std::span<const std::uint32_t> which;
  const PathState* states;
  const Ray* rays;
  const Hit* hits;
  const SurfacePoint* points;
  // Rays to lights and what they bring; paths that go on.
  PathGain* gains;
  Ray* shadow_rays;
  LightDensities* densities = nullptr;  // of the gains; null: not wanted
  std::size_t gained = 0;
  PathState* next_states;
  Ray* next_rays;
  std::size_t going_on = 0;
};

// Camera paths before they have a ray, and the pixels that they are for.
struct CameraPaths {
  const Camera& camera;
  ivec2 resolution;
  vec2 extent;
  bool thin_lens;
  const PixelFilter* filter;  // null: the pixel's box
  std::uint32_t index;        // of the sample
  std::span<const ivec2> pixels;
  PathSample* paths;
};

// Paths that begin over a hemisphere, one in each stratum: they have their random numbers, and get their rays.
struct HemispherePaths {
  const HemisphereStrata& strata;
  bool even;  // over solid angle; else over projected solid angle
  const Frame& frame;
  vec3 origin;
  int first;  // stratum of the first path
  std::span<PathSample> paths;
};

// Hits on triangles of the world, and where their surfaces go.
struct TriangleHits {
  const Scene& scene;
  std::span<const std::uint32_t> which;
  const Ray* rays;
  const Hit* hits;
  SurfacePoint* points;
};

using MeetMaterial = void (*)(PathEvents& events);
using AskMaterial = void (*)(const BsdfEvents& events);
struct PathKernels {
  void (*start)(const CameraPaths& paths);
  void (*start_hemisphere)(const HemispherePaths& paths);
  void (*place)(const TriangleHits& hits);
  MeetMaterial meet[std::variant_size_v<Material>];  // by the material's index
  AskMaterial ask[std::variant_size_v<Material>];
};
const PathKernels& path_kernels();  // of the instruction set that is chosen
const PathKernels& path_kernels_one();
#if defined(__x86_64__)
const PathKernels& path_kernels_sse();
const PathKernels& path_kernels_avx2();
const PathKernels& path_kernels_avx512();
#endif

template <class F>
struct PathLanes {
  Vec3<F> throughput;
  F eta_scale, pdf_bsdf;
  SamplerOf<F> numbers;
};

template <class F>
struct RayLanes {
  Vec3<F> origin{0.0f}, direction{0.0f};
  F t_max{infinity};
};

template <class F>
RayLanes<F> shadow_ray(const SurfaceOf<F>& point, const LightSampleOf<F>& light) {
  const Vec3<F> origin = ray_origin(point, light.wi);
  const Mask<F> infinite = light.distance == infinity;
  return {origin, select(infinite, light.wi, light.end - origin), select(infinite, F(infinity), F(1 - 4 * unit_roundoff))};
}

// The light that a light sample brings; black where nothing comes of it.
template <class F>
struct GainLanes {
  Vec3<F> radiance{0.0f};
  F pdf_light{0.0f}, pdf_bsdf{0.0f};  // where they are wanted
  RayLanes<F> ray;
};

// One light sample, MIS-weighted with BSDF sampling. As sample_direct_light.
template <class F, class Placed>
void add_direct_light(const PathEvents& events, const SurfaceOf<F>& point, const Placed& bsdf, const Vec3<F>& wo,
                      PathLanes<F>& path, Mask<F> active, GainLanes<F>& gain) {
  const Vec2<F> u = path.numbers.get_2d();
  if (events.mis == MisMode::bsdf && !events.lights.any_delta()) return;
  const LightSampleOf<F> light = sample_lights<F>(events.lights, ray_origin(point, wo), u, active);
  Mask<F> wanted = active & (light.pdf_solid_angle > 0);
  if (events.mis == MisMode::bsdf) wanted = wanted & light.delta;
  if (!any(wanted)) return;
  const Vec3<F> scattered = bsdf.evaluate(wo, light.wi);
  wanted = wanted & !is_black(scattered) & !is_black(light.radiance);
  F weight = 1.0f;
  if (events.mis != MisMode::light)
    weight = select(light.delta, F(1.0f), mis_weight<F>(events.mis, light.pdf_solid_angle, bsdf.pdf(wo, light.wi)));
  gain.radiance =
      select(wanted, path.throughput * (scattered * light.radiance * (weight / light.pdf_solid_angle)), Vec3<F>(0.0f));
  gain.ray = shadow_ray(point, light);
  if (events.densities == nullptr) return;
  gain.pdf_light = select(light.delta, F(0.0f), light.pdf_solid_angle);
  gain.pdf_bsdf = bsdf.pdf(wo, light.wi);
}

// The direction in which paths go on, and whether they do.
template <class F, class Placed>
Mask<F> scatter(const PathEvents& events, const SurfaceOf<F>& point, const Placed& bsdf, const Vec3<F>& wo, PathLanes<F>& path,
                RayLanes<F>& ray) {
  const F u_lobe = path.numbers.get_1d();
  const BsdfSampleOf<F> scattered = bsdf.sample(wo, u_lobe, path.numbers.get_2d());
  Mask<F> alive = !is_black(scattered.weight);
  path.throughput *= scattered.weight;
  path.eta_scale = select(scattered.transmitted, path.eta_scale * (scattered.eta * scattered.eta), path.eta_scale);
  path.pdf_bsdf = select(scattered.specular, F(0.0f), scattered.pdf_solid_angle);
  ray = {ray_origin(point, scattered.wi), scattered.wi, infinity};
  if (!events.roulette) return alive;
  const F survival = survival_of(path.throughput, path.eta_scale, events.evenness);
  alive = alive & survives_roulette(path.throughput, survival, path.numbers);
  return alive;
}

// Places drawn from the filter, in the place of those drawn evenly from the pixel; lane by lane.
template <class F>
[[gnu::noinline]] void draw_from_filter(const CameraPaths& paths, const Vec2<F>& pixel, Vec2<F>& jitter) {
  for (int i = 0; i < lane_count<F>; ++i) {
    const auto row = static_cast<std::uint64_t>(lane(pixel.y, i)), column = static_cast<std::uint64_t>(lane(pixel.x, i));
    const vec2 place = paths.filter->place({lane(jitter.x, i), lane(jitter.y, i)},
                                           row * static_cast<std::uint64_t>(paths.resolution.x) + column, paths.index);
    set_lane(jitter.x, i, place.x);
    set_lane(jitter.y, i, place.y);
  }
}

// A ray through each pixel, its place drawn from the filter (and over the lens where it is open).
template <class F>
RayLanes<F> sample_camera_rays(const CameraPaths& paths, const Vec2<F>& pixel, SamplerOf<F>& numbers) {
  Vec2<F> jitter = numbers.get_2d();
  if (paths.filter != nullptr) draw_from_filter<F>(paths, pixel, jitter);
  const Vec2<F> film(pixel.x + jitter.x, pixel.y + jitter.y);
  const Vec2<F> lens = paths.thin_lens ? numbers.get_2d() : Vec2<F>(0.5f, 0.5f);
  const CameraRayOf<F> ray(paths.camera, paths.resolution, paths.extent, film, lens);
  return {ray.origin, ray.direction, infinity};
}

// The direction is unit, in the world.
template <class F>
Vec3<F> hemisphere_direction(const HemispherePaths& paths, F ring, F sector, SamplerOf<F>& numbers) {
  const Vec2<F> u = numbers.get_2d();
  const FrameOf<Vec3<F>> frame{Vec3<F>(paths.frame.tangent), Vec3<F>(paths.frame.bitangent), Vec3<F>(paths.frame.normal)};
  return frame.to_world(paths.even ? paths.strata.even_direction(ring, sector, u)
                                   : paths.strata.cosine_direction(ring, sector, u));
}

template <class F, class M, class Read, class Write>
void meet_material(PathEvents& events, const Read& read, const Write& write) {
  const M& material = *static_cast<const M*>(events.material);
  for (std::size_t first = 0; first < events.which.size(); first += lane_count<F>) {
    SurfaceOf<F> point;
    Vec3<F> wo;
    PathLanes<F> path;
    const Mask<F> active = read(first, material.uses_uvs(), point, wo, path);
    const auto colour = [&](const TexturedRgb& c) { return read.colour(c, point, active); };
    const auto bsdf = place_lobes<F>(material, point, colour);
    GainLanes<F> gain;
    RayLanes<F> onwards;
    if (material.has_non_specular())
      add_direct_light(events, point, bsdf, wo, path, active, gain);
    else
      path.numbers.get_2d();
    Mask<F> alive = false;
    if (events.scatters) alive = active & scatter(events, point, bsdf, wo, path, onwards);
    write(first, active & !is_black(gain.radiance), gain, alive, path, onwards);
  }
}

}  // namespace etendue
