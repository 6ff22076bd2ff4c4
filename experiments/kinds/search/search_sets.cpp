#include "experiments/kinds/search/search_sets.h"

#include "accel/registry.h"
#include "experiments/kinds/structures/stage.h"
#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "integrators/photons/photons.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr float carry_below = 0.25f;  // as photon mapping's default

std::unique_ptr<RayQuery> rays_of(const Scene& scene) { return find_ray_structure("binned-sah", {}).make(scene, {}); }

std::vector<vec3> take_along_curve(std::vector<vec3> points) {
  std::vector<vec3> sorted;
  sorted.reserve(points.size());
  for (const std::uint32_t i : along_curve(points)) sorted.push_back(points[i]);
  return sorted;
}

// Surfaces that the camera sees through film positions drawn by `film(i)`, in [0, 1)^2; at most `count` of them.
template <class Film>
std::vector<vec3> seen_points(const Scene& scene, const RayQuery& rays, std::uint64_t count, const Film& film) {
  constexpr int resolution = 1024;
  std::vector<vec3> points;
  for (std::uint64_t i = 0; i < 4 * count + 1000 && points.size() < count; ++i) {
    const Ray ray = scene.camera.ray(ivec2(resolution), film(i) * static_cast<float>(resolution), vec2(0.5f));
    if (const Hit hit = rays.closest(ray)) points.push_back(scene.surface_at(ray, hit).position);
  }
  return points;
}

// Queries come as an image of 512 x 512 pixels is rendered: tile by tile, so that they have neighbours; tiles at random, so
// that the first few stand for all.
constexpr int image_size = 512, tile_pixels = tile_size * tile_size;

std::vector<vec3> seen_in_tiles(const Scene& scene, const RayQuery& rays, std::uint64_t count, std::uint64_t seed) {
  return seen_points(scene, rays, count, [seed](std::uint64_t i) {
    Sampler sampler(SamplerKind::independent, seed, Stream::test, i / tile_pixels, 2);
    const vec2 tile = glm::floor(sampler.get_2d() * static_cast<float>(image_size / tile_size)) * static_cast<float>(tile_size);
    return (tile + vec2(i % tile_size, i / tile_size % tile_size) + 0.5f) / static_cast<float>(image_size);
  });
}

std::vector<vec3> seen_at_random(const Scene& scene, const RayQuery& rays, std::uint64_t count, std::uint64_t seed) {
  std::vector<vec3> points = seen_points(scene, rays, count, [seed](std::uint64_t i) {
    return Sampler(SamplerKind::independent, seed, Stream::test, i, 0).get_2d();
  });
  if (points.empty()) throw Error(fmt::format("{}: the camera sees no surface; expected one to put records on", scene.name));
  for (std::size_t i = 0; points.size() < count; ++i) points.push_back(points[i]);
  return points;
}

}  // namespace

PointSet photons_of_scene(const Scene& scene, std::uint64_t count, std::uint64_t queries, std::uint64_t seed) {
  const std::unique_ptr<RayQuery> rays = rays_of(scene);
  const Stage stage(scene, *rays, ivec2(1), seed);
  const RenderContext& context = stage.context();
  const RoughMaterials rough(scene, carry_below);
  PhotonPass pass;
  pass.max_scatterings = context.max_depth(0) - 1;
  std::vector<vec3> points;
  for (double emitted = static_cast<double>(count); points.size() < count;) {
    if (emitted > 4e9)
      throw Error(fmt::format("{}: {} photons do not land; expected lights that reach surfaces", scene.name, count));
    pass.count = static_cast<std::uint32_t>(emitted);
    points = trace_photons(context, rough, pass).position;
    emitted *= std::clamp(1.2 * static_cast<double>(count) / static_cast<double>(points.size() + 1), 2.0, 100.0);
  }
  points.resize(count);
  PointSet set{take_along_curve(std::move(points)), seen_in_tiles(scene, *rays, queries, seed)};
  if (set.queries.empty()) set.queries = set.points;
  return set;
}

PointSet clustered_points(double contrast, std::uint64_t count, std::uint64_t queries, std::uint64_t seed) {
  // The rest has density count / 4 on its two squares; the spot holds count / 2.
  const float side = contrast > 1 ? std::min(1.0f, std::sqrt(2 / static_cast<float>(contrast))) : 0;
  const auto place = [&](std::uint64_t i, std::uint64_t key) {
    Sampler sampler(SamplerKind::independent, seed, Stream::test, hash_keys(i, key), 0);
    const vec2 u = sampler.get_2d();
    if (side > 0 && i % 2 == 0) return vec3(0.3f * (1 - side) + side * u.x, 0, 0.3f * (1 - side) + side * u.y);
    return sampler.get_1d() < 0.5f ? vec3(u.x, 0, u.y) : vec3(0, u.x, u.y);
  };
  PointSet set;
  for (std::uint64_t i = 0; i < count; ++i) set.points.push_back(place(i, 0));
  // Tiles as of an image, their pixels' spacing at most a share of the spot's side.
  const float pixel = std::min(1.0f / image_size, side > 0 ? side / 32 : 1.0f);
  for (std::uint64_t i = 0; i < queries; ++i) {
    vec3 p = place(i / tile_pixels, 1);
    const vec2 offset = pixel * vec2(i % tile_size, i / tile_size % tile_size);
    p += p.y == 0 ? vec3(offset.x, 0, offset.y) : vec3(0, offset);
    set.queries.push_back(p);
  }
  set.points = take_along_curve(std::move(set.points));
  return set;
}

RecordSet records_of_scene(const Scene& scene, double spread, double covering, std::uint64_t count, std::uint64_t queries,
                           std::uint64_t seed) {
  const std::unique_ptr<RayQuery> rays = rays_of(scene);
  RecordSet set;
  set.centres = seen_at_random(scene, *rays, count, seed);
  set.queries = seen_in_tiles(scene, *rays, queries, seed);
  Bounds bounds;
  for (const vec3& p : set.centres) bounds.extend(p);
  const float extent = std::max(max_component(bounds.diagonal()), 1e-6f);
  for (std::uint64_t i = 0; i < count; ++i) {
    const float u = Sampler(SamplerKind::independent, seed, Stream::test, i, 1).get_1d();
    set.radii.push_back(extent * std::pow(static_cast<float>(spread), u - 1) / std::sqrt(static_cast<float>(count)));
  }
  // Records over a point of a surface grow as their radius squared, more or less; a few rounds find the factor.
  const std::size_t probes = std::min<std::size_t>(set.queries.size(), 200);
  const double wanted = std::min(covering, 0.5 * static_cast<double>(count));
  for (int round = 0; round < 5 && probes > 0; ++round) {
    const auto records = find_record_structure("hash-grid", {}).make(bounds);
    for (std::uint32_t i = 0; i < count; ++i) records->insert(set.centres[i], set.radii[i], i);
    std::size_t found = 0;
    Neighbours out;
    for (std::size_t i = 0; i < probes; ++i) {
      records->covering(set.queries[i * set.queries.size() / probes], out);
      found += out.size();
    }
    const double mean = (static_cast<double>(found) + 0.5) / static_cast<double>(probes);
    const auto factor = static_cast<float>(std::clamp(std::sqrt(wanted / mean), 0.2, 5.0));
    for (float& radius : set.radii) radius *= factor;
  }
  return set;
}

}  // namespace etendue
