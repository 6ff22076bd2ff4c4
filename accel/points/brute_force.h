// Brute force: tests every point in every query. It is the reference for the other point structures.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

class PointBruteForce {
 public:
  void build(std::span<const vec3> points) { points_ = points; }
  void within(const vec3& p, float r, Neighbours& out) const;
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return 0; }

 private:
  std::span<const vec3> points_;
};

}  // namespace etendue
