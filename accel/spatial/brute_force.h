// Brute force: every primitive for every ray. Without boxes that could lose a hit, it is the reference for the other
// structures, and fast enough for a handful of primitives.
#pragma once

#include "accel/kernels/leaf.h"

namespace etendue {

class BruteForce : public LeafQueries<BruteForce, LeafTest> {
 public:
  // `geometry` must outlive the structure.
  explicit BruteForce(const Geometry& geometry);

  template <class Count, class Leaf>
  void traverse(const Ray&, const float&, Count&, const Leaf& leaf) const {
    leaf(all_);
  }
  const Leaves& leaves() const { return leaves_; }
  RayStructureStats stats() const;

 private:
  Leaves leaves_;
  Leaves::Run all_;
};

struct RayEntry brute_entry();  // its row of the registry

}  // namespace etendue
