// kd-tree over points: nanoflann's ([Blanco2014]), with result sets of our own.
//
// nanoflann keeps points at a squared distance strictly below the limit and prunes by sums that rounding may push a little
// above a point's distance. So it searches with a limit slightly too large, and the result set decides by the exact rule,
// distance^2 <= r^2. Coordinates should stay below 1e18, whose squares a float can hold. The build is serial, and the tree
// holds indices: a query reads the caller's positions at random.
#pragma once

#include "accel/points/neighbourhood.h"

#include <memory>

namespace etendue {

class NanoflannTree {
 public:
  NanoflannTree();
  ~NanoflannTree();
  NanoflannTree(NanoflannTree&&) noexcept;
  NanoflannTree& operator=(NanoflannTree&&) noexcept;

  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const;
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace etendue
