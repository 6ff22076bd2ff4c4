// One photon's path: emitted, traced, stored where rough vertices catch it. It serves integrators/photons/photons.cpp and its
// emissions.
#pragma once

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/core/sampling.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/photons/emission/visible_region.h"
#include "integrators/photons/photon_event.h"

namespace etendue {

class PhotonTracer {
 public:
  PhotonTracer(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass)
      : context_(context), rough_materials_(rough_materials), pass_(pass) {}
  ~PhotonTracer() { count(Counter::rays, rays_); }
  PhotonTracer(const PhotonTracer&) = delete;
  PhotonTracer& operator=(const PhotonTracer&) = delete;

  // Appends what a path stores to `out`, powers times `share`. True if any of it lies where photons matter. `numbers` has
  // emission() -> EmissionNumbers and pair() -> vec2.
  template <class Numbers>
  bool trace(Numbers& numbers, float share, Photons& out);

 private:
  bool stores(std::uint32_t history) const { return (pass_.keep & history) != 0; }

  const RenderContext& context_;
  const RoughMaterials& rough_materials_;
  const PhotonPass& pass_;
  std::uint64_t rays_ = 0;
};

template <class Numbers>
bool PhotonTracer::trace(Numbers& numbers, float share, Photons& out) {
  const EmissionNumbers u = numbers.emission();
  const auto emitted = context_.lights.emit(u[0], {u[1], u[2]}, {u[3], u[4]});
  if (!emitted || is_black(emitted->power)) return false;
  Ray ray = emitted->ray;
  Rgb power = emitted->power * share;
  std::uint32_t history = photon_direct;
  bool matters = false;
  for (int scatterings = 0;; ++scatterings) {
    ++rays_;
    const Hit hit = context_.rays.closest(ray);
    if (!hit) return matters;
    const SurfacePoint point = context_.scene.surface_at(ray, hit);
    if (meets_own_wall(ray, point)) return matters;
    const vec3 from = -ray.direction;
    const bool rough = rough_materials_(point.material);
    const vec3 normal = glm::dot(from, point.normal) < 0 ? -point.normal : point.normal;
    if (rough_materials_.stores(point.material) && stores(history)) {
      // A mask stops a share of the photons that arrive, which stand for all: it stops as large a share of camera rays again.
      out.add(point.position, power / context_.stopped_share(hit), from, hit.t, normal, static_cast<PhotonHistory>(history),
              scatterings, point.layer);
      matters = matters || !pass_.visible || pass_.visible->contains(point.position, normal);
    }
    if (scatterings >= pass_.max_scatterings) return matters;
    const auto colour = [&](const TexturedRgb& c) { return evaluate(c, context_.scene.textures, point.uv); };
    const PhotonRules rules{rough_materials_.stores(point.material), rough, pass_.keep};
    RayLanes<float> onwards;
    const bool goes_on = std::visit(
        [&](const auto& material) {
          return scatter_photon<float>(material, point, colour, from, normal, rules, power, history, numbers, onwards);
        },
        context_.scene.materials[point.material]);
    if (!goes_on) return matters;
    ray = {.origin = onwards.origin, .direction = onwards.direction};
  }
}

// body(first, last, Photons&) over runs of [0, count) of fixed length, in parallel; what they store, in order.
template <class Body>
Photons trace_in_chunks(std::uint32_t count, const Body& body) {
  constexpr std::uint32_t chunk = 4096;
  std::vector<Photons> chunks(count / chunk + (count % chunk != 0));
  parallel_for(chunks.size(), 1, [&](std::size_t c) {
    const auto first = static_cast<std::uint32_t>(c) * chunk;
    const std::uint32_t size = std::min(chunk, count - first);
    Photons traced;
    traced.reserve(2 * std::size_t{size});  // what most scenes store
    body(first, first + size, traced);
    chunks[c].append(traced);  // takes no more room than there are photons
  });
  return joined(std::move(chunks));
}

}  // namespace etendue
