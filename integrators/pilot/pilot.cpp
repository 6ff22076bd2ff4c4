#include "integrators/pilot/pilot.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/image/metrics.h"
#include "framework/transport/ray_tools.h"
#include "integrators/paths/path.h"
#include "integrators/paths/path_choices.h"
#include "integrators/photons/emission/visible_region.h"
#include "integrators/photons/photon_camera_path.h"
#include "integrators/photons/photon_path.h"
#include "integrators/photons/wall_grid.h"

#include <cmath>
#include <numeric>

namespace etendue {

namespace {

constexpr int path_groups = 8, paths_a_group = 2, vertex_samples = 8;
constexpr std::uint32_t photon_paths = 16384;
constexpr int most_scatterings = 256;  // of a photon: in a white room it would go on, and tell no more
constexpr const char* point_structure = "kd-tree";
constexpr double unknown_contrast = 2;   // of caustics that no photons tell of: neither even nor sharp
constexpr float record_accuracy = 0.2f;  // as CacheParams::accuracy by default

double rays_so_far() {
  const CounterValues values = read_counters();
  return static_cast<double>(values[static_cast<std::size_t>(Counter::rays)] +
                             values[static_cast<std::size_t>(Counter::shadow_rays)]);
}

ivec2 pilot_resolution(ivec2 resolution, double share) {
  const double pixels = static_cast<double>(resolution.x) * resolution.y;
  const double factor = std::max(1.0, std::sqrt(pixels / (share * pilot_pixels)));
  return glm::max(ivec2(1), ivec2(dvec2(resolution) / factor + 0.5));
}

// The relMSE of one of `samples` that make up each group's value, from the scatter of the groups about their mean.
double error_of_one(const std::vector<Image>& groups, int samples) {
  const auto n = static_cast<double>(groups.size());
  double sum = 0;
  for (std::size_t i = 0; i < groups[0].pixels.size(); ++i) {
    dvec3 mean(0), squares(0);
    for (const Image& group : groups) mean += group.pixels[i] / n;
    for (const Image& group : groups) squares += (group.pixels[i] - mean) * (group.pixels[i] - mean) / (n - 1);
    for (int c = 0; c < 3; ++c) sum += squares[c] / (mean[c] * mean[c] + relmse_epsilon);
  }
  return sum * samples / (3 * static_cast<double>(groups[0].pixels.size()));
}

void look_at_paths(RenderContext& small, PilotFindings& findings) {
  const auto path = path_entry().make({{"sampler", {std::string("independent"), {}}}});
  path->prepare(small);
  const double before = rays_so_far();
  std::vector<Image> groups;
  for (int g = 0; g < path_groups; ++g) {
    Film film(small.resolution);
    for (int i = 0; i < paths_a_group; ++i) path->iteration(small, static_cast<std::uint32_t>(g * paths_a_group + i), film);
    groups.push_back(film.mean());
  }
  findings.path_error = error_of_one(groups, paths_a_group);
  findings.rays_per_path =
      (rays_so_far() - before) / (static_cast<double>(groups[0].pixels.size()) * path_groups * paths_a_group);
}

// Rays that leave vertices, and those of them that meet light by way of specular surfaces.
struct Probes {
  int count = 0, caustics = 0;
  float brightest = 0;  // luminance of what they find so
};

// Holds what one pixel of the small image found.
struct Seen {
  int vertices = 0, diffuse = 0, by_specular = 0;
  Probes diffuse_probes, glossy_probes;  // of diffuse vertices, and of the others
  double light = 0;                      // luminance of what the samples find, summed,
  double behind_glass = 0;               // and of what they would if glass bent no light of delta lights
  double inverse_distance = 0;           // summed over the probes, 1/m
  double area = 0;                       // of a real pixel's footprint, summed over the vertices, m^2
  std::vector<vec3> positions;           // of the vertices,
  std::vector<vec3> origins;             // where rays leave them on the side that is seen,
  std::vector<vec3> sides;               // and the normals of those sides; 0: light passes, and both are seen
};

class Vertices {
 public:
  Vertices(const RenderContext& small, ivec2 real_resolution, float narrow)
      : small_(small),
        rough_(small.scene, narrow, LobeTails::followed, gathers_coats(small)),
        groups_(vertex_samples, Image(small.resolution)) {
    seen_.resize(groups_[0].pixels.size());
    const Camera& camera = small.scene.camera;
    const vec2 pixel = 2.0f * camera.half_extent(real_resolution) / vec2(real_resolution);
    solid_angle_ = pixel.x * pixel.y;
  }

  void look(PilotFindings& findings, ivec2 real_resolution) {
    parallel_pixels(small_.resolution, [&](ivec2 pixel) { look(pixel); });
    findings.direct_error = error_of_one(groups_, 1);
    double vertices = 0, diffuse = 0, by_specular = 0, records = 0, light = 0, behind_glass = 0;
    Probes diffuse_probes, glossy_probes;
    const auto add = [](Probes& sum, const Probes& some) {
      sum.count += some.count;
      sum.caustics += some.caustics;
      sum.brightest = std::max(sum.brightest, some.brightest);
    };
    for (const Seen& seen : seen_) {
      vertices += seen.vertices;
      diffuse += seen.diffuse;
      by_specular += seen.by_specular;
      records += records_a_pixel(seen);
      add(diffuse_probes, seen.diffuse_probes);
      add(glossy_probes, seen.glossy_probes);
      light += seen.light;
      behind_glass += seen.behind_glass;
      positions_.insert(positions_.end(), seen.positions.begin(), seen.positions.end());
      origins_.insert(origins_.end(), seen.origins.begin(), seen.origins.end());
      sides_.insert(sides_.end(), seen.sides.begin(), seen.sides.end());
    }
    near_ = small_.make_points(point_structure);
    near_->build(positions_);
    const auto small_pixels = static_cast<double>(seen_.size());
    findings.surface = std::min(1.0, vertices / (small_pixels * vertex_samples));
    if (vertices > 0) {
      findings.diffuse = diffuse / vertices;
      findings.by_specular = by_specular / vertices;
    }
    const Probes& probes = diffuse_probes.count > 0 ? diffuse_probes : glossy_probes;
    brightest_ = probes.brightest;
    if (probes.count > 0) findings.caustic_hits = static_cast<double>(probes.caustics) / probes.count;
    if (behind_glass > 0) behind_glass_ = behind_glass / (light + behind_glass);
    findings.records = records * static_cast<double>(real_resolution.x) * real_resolution.y / small_pixels;
  }

  const RoughMaterials& rough_materials() const { return rough_; }
  // Luminance of the brightest light that probes met by way of specular surfaces; 0: they met none.
  float brightest() const { return brightest_; }
  // Share of the light that comes straight through glass from delta lights, if glass bent none of it.
  double behind_glass() const { return behind_glass_; }
  // Is the side of a surface seen on which this photon landed? One of the nearest vertices passes the side test of gathers
  // (photon_gather.h).
  bool see(const Photons& photons, std::size_t i) const {
    return any_near(photons, i, [](const Neighbour&) { return true; });
  }
  // Nor does a wall hide the photon from that vertex?
  bool reach(const Photons& photons, std::size_t i) const {
    return any_near(photons, i, [&](const Neighbour& n) {
      if (sides_[n.id] == vec3(0)) return true;
      const vec3& landed = photons.position[i];
      const vec3 end = before_landing(landed, photons.direction[i], photons.flown[i], std::sqrt(n.distance_squared));
      return sees_landed(small_, segment(origins_[n.id], end), landed);
    });
  }

 private:
  template <class Accepts>
  bool any_near(const Photons& photons, std::size_t i, const Accepts& accepts) const {
    static thread_local Neighbours near;
    near_->nearest(photons.position[i], vertex_samples, infinity, near);
    const vec3 normal = photons.side[i].normal();
    return std::ranges::any_of(near, [&](const Neighbour& n) {
      return (sides_[n.id] == vec3(0) || glm::dot(sides_[n.id], normal) >= 0.1f) && accepts(n);
    });
  }

  void look(ivec2 pixel) {
    const std::uint64_t key = pixel_index(pixel, small_.resolution);
    const PhotonCameraPath path{small_, rough_, small_.max_depth(0)};
    for (int i = 0; i < vertex_samples; ++i) {
      const auto index = static_cast<std::uint32_t>(i);
      Sampler way(SamplerKind::independent, small_.seed, Stream::camera, key, index);
      Sampler light(SamplerKind::independent, small_.seed, Stream::gather, key, index);
      Sampler probe(SamplerKind::independent, small_.seed, Stream::probe, key, index);
      const Ray ray = sample_camera_ray(small_, pixel, way);
      Rgb direct(0);
      const Rgb rest = path(
          ray, way, light,
          [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth, float distance) {
            if (small_.lights.any_delta())
              seen_[key].behind_glass += luminance(throughput * through_glass(point, bsdf, wo, light));
            direct += throughput * all_direct_light(small_, point, bsdf, wo, light, direct_);
            note(seen_[key], point, bsdf, wo, depth, distance, probe);
          });
      const Rgb value = direct + rest;
      groups_[index].at(pixel.x, pixel.y) = is_finite(value) ? dvec3(value) : dvec3(0);
      if (is_finite(value)) seen_[key].light += luminance(value);
    }
  }

  void note(Seen& seen, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, float distance,
            Sampler& probe) const {
    ++seen.vertices;
    seen.by_specular += depth > 0 ? 1 : 0;
    const vec3 facing = glm::dot(point.normal, wo) < 0 ? -point.normal : point.normal;
    seen.positions.push_back(point.position);
    seen.origins.push_back(ray_origin(point, facing));
    seen.sides.push_back(bsdf.transmits() ? vec3(0) : facing);
    if (!is_cached(bsdf)) {
      const float u_lobe = probe.get_1d();
      if (const BsdfSample lobe = bsdf.sample(wo, u_lobe, probe.get_2d()))
        look_along(spawn_ray(point, lobe.wi), seen.glossy_probes, probe);
      return;
    }
    ++seen.diffuse;
    const float cosine = std::max(0.05f, std::abs(glm::dot(point.normal, wo)));
    seen.area += solid_angle_ * square(small_.scene.camera.spread(distance)) / cosine;
    const vec3 direction = Frame::from_normal(facing).to_world(sample_cosine_hemisphere(probe.get_2d()));
    if (const Hit hit = look_along(spawn_ray(point, direction), seen.diffuse_probes, probe))
      seen.inverse_distance += 1 / std::max<double>(hit.t, std::numeric_limits<float>::min());
  }

  // Counts what the ray meets, and says where.
  Hit look_along(const Ray& ray, Probes& probes, Sampler& sampler) const {
    const Hit hit = trace(small_, ray);
    ++probes.count;
    const float light = hit ? light_by_specular(ray, hit, sampler) : 0;
    probes.caustics += light > 0 ? 1 : 0;
    probes.brightest = std::max(probes.brightest, light);
    return hit;
  }

  // The light that the next light sample sends from a point, spot or direction that glass alone hides.
  Rgb through_glass(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, Sampler sampler) const {
    constexpr int most_passed = 8;
    const auto light = small_.lights.sample(ray_origin(point, wo), sampler.get_2d());
    if (!light || !light->delta || !bsdf.has_non_specular()) return Rgb(0);
    Ray ray = shadow_ray(point, *light);
    for (int passed = 0; passed <= most_passed; ++passed) {
      const Hit hit = trace(small_, ray);
      if (!hit) return passed > 0 ? bsdf.evaluate(wo, light->wi) * light->radiance / light->pdf_solid_angle : Rgb(0);
      const Material& material = small_.scene.materials[small_.scene.surface_at(ray, hit).material];
      if (!std::holds_alternative<Dielectric>(material) || has_non_specular(material)) return Rgb(0);
      ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    }
    return Rgb(0);
  }

  float light_by_specular(Ray ray, Hit hit, Sampler& sampler) const {
    constexpr int most_events = 8;
    for (int events = 0; events < most_events; ++events) {
      float passed = 0;
      if (events > 0)
        for_passed_lights(small_, ray, hit ? hit.t : infinity, [&](const SurfacePoint& light) {
          passed += luminance(small_.lights.emitted(light, -ray.direction));
        });
      if (!hit) return events > 0 ? passed + luminance(small_.lights.environment(ray.direction)) : 0;
      const SurfacePoint point = small_.scene.surface_at(ray, hit);
      const float light = passed + luminance(small_.lights.emitted(point, -ray.direction));
      if (events > 0 && light > 0) return light;
      if (rough_(point.material)) return 0;
      const Bsdf bsdf(small_.scene, point);
      const float u_lobe = sampler.get_1d();
      const BsdfSample scattered = bsdf.sample(-ray.direction, u_lobe, sampler.get_2d());
      if (!scattered) return 0;
      ray = spawn_ray(point, scattered.wi);
      hit = trace(small_, ray);
    }
    return 0;
  }

  // A record serves as far as `record_accuracy` times the harmonic mean distance of what its hemisphere sees, and no less than
  // a few pixels; those at the corners of a pattern overlap, so that each has about half of its disc to itself.
  static double records_a_pixel(const Seen& seen) {
    constexpr double fewest_pixels = 9;
    const int probes = seen.diffuse_probes.count;
    if (probes == 0 || !(seen.inverse_distance > 0)) return 0;
    const double radius = record_accuracy * probes / seen.inverse_distance, footprint = seen.area / seen.diffuse;
    const double own = std::max(0.5 * pi * radius * radius, fewest_pixels * footprint);
    return footprint / own * std::min(1.0, static_cast<double>(seen.diffuse) / vertex_samples);
  }

  const RenderContext& small_;
  RoughMaterials rough_;
  std::vector<Image> groups_;
  std::vector<Seen> seen_;
  std::vector<vec3> positions_, origins_, sides_;  // of the vertices of all pixels
  std::unique_ptr<PointQuery> near_;
  const MisMode direct_ = choose_direct(small_);
  float solid_angle_ = 0, brightest_ = 0;
  double behind_glass_ = 0;
};

// The median density about a photon of those that fall on `area`, by its eighth neighbour, over the mean over the area.
double contrast_of(const RenderContext& context, const std::vector<vec3>& photons, double area) {
  constexpr std::size_t near = 8, most = 1500;
  if (photons.size() <= near) return 0;
  const auto query = context.make_points(point_structure);
  query->build(photons);
  const std::size_t stride = photons.size() / most + 1;  // of those that are asked
  std::vector<float> squared((photons.size() + stride - 1) / stride, std::numeric_limits<float>::max());
  parallel_for(squared.size(), 16, [&](std::size_t i) {
    static thread_local Neighbours found;
    query->nearest(photons[i * stride], near + 1, infinity, found);  // itself is the first
    if (found.size() > near) squared[i] = std::max(found[near].distance_squared, std::numeric_limits<float>::min());
  });
  return near * area / (pi * median(squared) * static_cast<double>(photons.size()));
}

// The share of these photons that a gather reaches past walls, by one of each `stride`.
double share_reached(const Vertices& vertices, const Photons& photons, const std::vector<std::size_t>& ids,
                     std::size_t stride) {
  std::vector<std::uint8_t> reached((ids.size() + stride - 1) / stride);
  parallel_for(reached.size(), 16, [&](std::size_t i) { reached[i] = vertices.reach(photons, ids[i * stride]) ? 1 : 0; });
  return std::accumulate(reached.begin(), reached.end(), 0.0) / static_cast<double>(std::max<std::size_t>(reached.size(), 1));
}

// Photons by power, the same as trace_photons has them, and of each: is it from a light that no ray can meet, or far brighter
// than the `brightest` that rays did meet (0: they met none, and tell nothing)? They would have met one as bright that brings
// as much light.
struct PilotPhotons {
  Photons photons;
  std::vector<std::uint8_t> unmet;
};

bool is_unmet(const Scene& scene, const LightRay& emitted, float brightest) {
  constexpr float far_brighter = 4;
  if (is_delta(scene.lights[emitted.light])) return true;
  const float cosine = glm::dot(emitted.normal, emitted.ray.direction);
  return brightest > 0 && luminance(emitted.power) * emitted.pdf > far_brighter * brightest * cosine;
}

PilotPhotons trace_pilot_photons(const RenderContext& small, const RoughMaterials& rough, float brightest,
                                 const PhotonPass& pass) {
  const PathNumbers of_pass(small.seed, pass, pass.key);
  std::vector<std::uint32_t> stored(pass.count);  // by path
  std::vector<std::uint8_t> of_unmet(pass.count);
  PilotPhotons out;
  out.photons = trace_in_chunks(pass.count, [&](std::uint32_t first, std::uint32_t last, Photons& traced) {
    PhotonTracer tracer(small, rough, pass);
    for (std::uint32_t i = first; i < last; ++i) {
      SampledNumbers numbers(of_pass, i);
      const EmissionNumbers u = numbers.emission();
      const auto emitted = small.lights.emit(u[0], {u[1], u[2]}, {u[3], u[4]});
      of_unmet[i] = emitted && is_unmet(small.scene, *emitted, brightest) ? 1 : 0;
      const std::size_t before = traced.size();
      tracer.trace(numbers, 1 / static_cast<float>(pass.count), traced);
      stored[i] = static_cast<std::uint32_t>(traced.size() - before);
    }
  });
  for (std::uint32_t i = 0; i < pass.count; ++i) out.unmet.insert(out.unmet.end(), stored[i], of_unmet[i]);
  return out;  // they light nothing, and are not among the photons that are counted
}

void look_at_photons(const RenderContext& small, const Vertices& vertices, PilotFindings& findings) {
  if (small.lights.empty() || small.bounds.empty()) return;
  const RoughMaterials& rough = vertices.rough_materials();
  const float diagonal = glm::length(small.bounds.diagonal());
  const int depth = small.max_depth(0);
  const auto region = find_seen(small, rough, {4, depth, SamplerKind::independent, true}, 0.02f * diagonal);
  const auto [photons, unmet] = trace_pilot_photons(
      small, rough, vertices.brightest(),
      {photon_paths, hash_keys(small.seed, 3u), std::clamp(depth - 1, 0, most_scatterings), photon_any, SamplerKind::sobol});
  double all = 0, direct = 0, caustic = 0, caustic_unmet = 0;
  std::vector<std::size_t> seen;
  std::vector<vec3> caustics;
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const bool is_caustic = (photons.side[i].history & photon_caustic) != 0;
    // About borders the region is too wide: there a caustic that nobody sees would count.
    if (!region->contains(photons.position[i], photons.side[i].normal()) || (is_caustic && !vertices.see(photons, i))) continue;
    const double power = luminance(photons.power[i]);
    seen.push_back(i);
    all += power;
    if (photons.side[i].history & photon_direct) direct += power;
    if (!is_caustic) continue;
    caustic += power;
    if (unmet[i] != 0) caustic_unmet += power;
    caustics.push_back(photons.position[i]);
  }
  // The region reaches through walls, behind which nearly all of them may lie: some tell the share, or all where it is small.
  constexpr std::size_t asked = 512;
  constexpr double small_share = 0.02;
  double reached = share_reached(vertices, photons, seen, seen.size() / asked + 1);
  if (reached < small_share) reached = share_reached(vertices, photons, seen, 1);
  findings.photons_seen = static_cast<double>(seen.size()) / photon_paths * reached;
  if (all > 0) {
    findings.direct_light = direct / all;
    findings.caustic_photons = static_cast<double>(caustics.size());
    findings.caustic_light = caustic / all;
    findings.unmet_caustics = caustic_unmet / all;
    const double area = seen_area(small, rough, {1, depth, SamplerKind::independent, true});
    findings.caustic_contrast = contrast_of(small, caustics, area);
  }
  // Where hardly any photon comes through a window, straight rays tell about how much light does.
  if (caustics.size() < fewest_caustics && vertices.behind_glass() > findings.unmet_caustics) {
    findings.unmet_caustics = vertices.behind_glass();
    findings.caustic_light = std::max(findings.caustic_light, findings.unmet_caustics);
    findings.caustic_contrast = unknown_contrast;
  }
}

}  // namespace

PilotFindings run_pilot(const RenderContext& context, float narrow, double share) {
  const auto timed = context.phases.measure("pilot");
  const double before = rays_so_far();
  RenderContext small = context;
  small.resolution = pilot_resolution(context.resolution, share);
  small.window = {};                                    // which is of the real image's pixels
  small.seed = hash_keys(context.seed, 0x70696c6f74u);  // of its own: nothing of the pilot is in the image
  PilotFindings findings{.share = share};
  look_at_paths(small, findings);
  small.choose_lights_by(LightChoice::by_need);  // paths may have left some to their BSDF samples
  Vertices vertices(small, context.resolution, narrow);
  vertices.look(findings, context.resolution);
  look_at_photons(small, vertices, findings);
  findings.rays = rays_so_far() - before;
  return findings;
}

}  // namespace etendue
