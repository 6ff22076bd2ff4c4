// Brute force without a copy: every primitive for every ray, read where the scene has it. The last resort where there is no
// memory for anything else: it holds the ids of invalid primitives, of which most scenes have none. Slower than BruteForce,
// which keeps copies side by side, with the same hits.
#pragma once

#include "accel/kernels/counting.h"
#include "accel/kernels/reference_test.h"

#include <array>

namespace etendue {

class BruteInPlace {
 public:
  // `geometry` must outlive the structure.
  explicit BruteInPlace(const Geometry& geometry);

  Hit closest(const Ray& ray) const { return closest_with(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return occluded_with(ray, CountNothing{}); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const { return closest_with(ray, CountWork{counters}); }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const { return occluded_with(ray, CountWork{counters}); }
  RayStructureStats stats() const;

 private:
  template <class Leaf>
  void for_runs(const Leaf& leaf) const;
  template <class Count>
  Hit closest_with(const Ray& ray, Count count) const;
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const;

  const Geometry* geometry_;
  std::vector<std::uint32_t> invalid_;  // ascending
};

// Calls leaf(ids) over all valid primitives, a few at a time, until that returns true.
template <class Leaf>
void BruteInPlace::for_runs(const Leaf& leaf) const {
  std::array<std::uint32_t, 64> ids;
  std::size_t size = 0;
  auto invalid = invalid_.begin();
  for (std::uint32_t id = 0; id < geometry_->primitive_count(); ++id) {
    if (invalid != invalid_.end() && *invalid == id) {
      ++invalid;
      continue;
    }
    ids[size++] = id;
    if (size < ids.size()) continue;
    if (leaf(std::span<const std::uint32_t>(ids))) return;
    size = 0;
  }
  if (size > 0) leaf(std::span<const std::uint32_t>(ids.data(), size));
}

template <class Count>
Hit BruteInPlace::closest_with(const Ray& ray, Count count) const {
  return closest_by_reference(*geometry_, ray, count, [&](const float&, const auto& leaf) { for_runs(leaf); });
}

template <class Count>
bool BruteInPlace::occluded_with(const Ray& ray, Count count) const {
  return occluded_by_reference(*geometry_, ray, count, [&](const float&, const auto& leaf) { for_runs(leaf); });
}

}  // namespace etendue
