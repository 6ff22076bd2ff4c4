#include "accel/scene/with_masks.h"

#include "framework/core/rng.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

namespace etendue {

namespace {

class WithMasks final : public RayQuery {
 public:
  WithMasks(std::unique_ptr<RayQuery> structure, const Scene& scene) : structure_(std::move(structure)), scene_(scene) {
    fallback = structure_->fallback;
  }

  Hit closest(const Ray& ray) const override {
    return stopped(ray, structure_->closest(ray), [this](const Ray& rest) { return structure_->closest(rest); });
  }
  bool occluded(const Ray& ray) const override { return static_cast<bool>(closest(ray)); }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const override;
  Hit passed_light(const Ray& ray) const override {
    Ray rest = ray;
    Hit hit = structure_->closest(rest);
    for (; hit && (!scene_.emits_at(hit) || stops(ray, hit)); hit = structure_->closest(rest)) rest = beyond(rest, hit);
    return hit;
  }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const override {
    const auto ask = [&](const Ray& rest) { return structure_->closest_counted(rest, counters); };
    return stopped(ray, ask(ray), ask);
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const override {
    return static_cast<bool>(closest_counted(ray, counters));
  }
  RayStructureStats stats() const override { return structure_->stats(); }

 private:
  bool stops(const Ray& ray, const Hit& hit) const {
    const float opacity = scene_.opacity_at(hit);
    if (opacity >= 1) return true;
    if (!(opacity > 0)) return false;
    const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
    const std::uint64_t hash =
        hash_keys(bits(ray.origin.x), bits(ray.origin.y), bits(ray.origin.z), bits(ray.direction.x), bits(ray.direction.y),
                  bits(ray.direction.z), hit.instance, hit.primitive, bits(hit.t));
    return to_unit_float(high_bits(hash)) < opacity;
  }
  // The part of the ray beyond the hit. Where a structure rounds t and answers one that is not beyond t_min, the ray still gets
  // shorter.
  static Ray beyond(Ray ray, const Hit& hit) {
    ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    return ray;
  }
  template <class Ask>
  Hit stopped(Ray ray, Hit hit, const Ask& ask) const {
    while (hit && !stops(ray, hit)) {
      ray = beyond(ray, hit);
      hit = ask(ray);
    }
    return hit;
  }

  std::unique_ptr<RayQuery> structure_;
  const Scene& scene_;
};

void WithMasks::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
  static thread_local std::vector<Ray> rest;  // for their memory
  static thread_local std::vector<std::uint32_t> of_rest;
  static thread_local std::vector<Hit> met;
  structure_->closest(rays, hits);
  rest.clear();
  of_rest.clear();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i] || stops(rays[i], hits[i])) continue;
    rest.push_back(beyond(rays[i], hits[i]));
    of_rest.push_back(static_cast<std::uint32_t>(i));
  }
  for (std::size_t left; !rest.empty(); rest.resize(left), of_rest.resize(left)) {
    met.resize(rest.size());
    structure_->closest(std::span<const Ray>(rest), std::span(met));
    left = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (!met[i] || stops(rest[i], met[i])) {
        hits[of_rest[i]] = met[i];
      } else {
        of_rest[left] = of_rest[i];
        rest[left++] = beyond(rest[i], met[i]);
      }
    }
  }
}

void WithMasks::occluded(std::span<const Ray> rays, std::span<bool> occluded) const {
  static thread_local std::vector<Hit> hits;  // for its memory
  hits.resize(rays.size());
  closest(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = static_cast<bool>(hits[i]);
}

}  // namespace

std::unique_ptr<RayQuery> with_masks(std::unique_ptr<RayQuery> structure, const Scene& scene) {
  if (!scene.has_masks()) return structure;
  return std::make_unique<WithMasks>(std::move(structure), scene);
}

}  // namespace etendue
