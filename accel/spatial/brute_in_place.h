// Brute force without a copy: every primitive for every ray, read where the scene has it. It is the last resort where there is
// no memory for anything else: it holds the ids of invalid primitives, of which most scenes have none. It is slower than
// BruteForce, which keeps copies side by side, and finds the same hits.
#pragma once

#include "accel/kernels/reference_test.h"

#include <array>

namespace etendue {

class BruteInPlace : public LeafQueries<BruteInPlace, ReferenceTest> {
 public:
  // `geometry` must outlive the structure.
  explicit BruteInPlace(const Geometry& geometry);

  // Shows all valid primitives, a few at a time.
  template <class Count, class Leaf>
  void traverse(const Ray&, const float&, Count&, const Leaf& leaf) const;
  const Geometry& leaves() const { return *geometry_; }
  RayStructureStats stats() const;

 private:
  const Geometry* geometry_;
  std::vector<std::uint32_t> invalid_;  // ascending
};

template <class Count, class Leaf>
void BruteInPlace::traverse(const Ray&, const float&, Count&, const Leaf& leaf) const {
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

}  // namespace etendue
