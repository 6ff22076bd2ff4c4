// Left-balanced kd-tree over points ([Jensen2001] section 4.5; [Bentley1975] for kd-trees): each node is a point that parts its
// subtree across the longest edge of that subtree's bounds, and all levels but the last are full, the last from the left. So
// the tree is an array in heap order, the children of node i are 2i and 2i + 1, and neither pointers nor leaves exist.
//
// Queries are iterative. A subtree beyond a node's plane is left out where the plane alone is farther than the limit, by the
// same float operations that make a point's distance: rounding is monotone, so this is exact without slack. Ties between
// coordinates are parted by id, hence the tree is unique and the parallel build deterministic. At most 2^30 points.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

class LeftBalancedTree {
 public:
  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const;
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return nodes_.size() * sizeof(Node); }

 private:
  struct Node {
    vec3 position;
    std::uint32_t id_and_axis;  // the axis in the upper two bits

    std::uint32_t id() const { return id_and_axis & 0x3fffffffu; }
    int axis() const { return static_cast<int>(id_and_axis >> 30); }
  };

  void place(std::span<PlacedPoint> points, std::size_t node);
  // visit(node, squared distance) for every node whose subtree has a plane within limit() of p on the way to it.
  template <class Limit, class Visit>
  void traverse(const vec3& p, const Limit& limit, const Visit& visit) const;

  std::vector<Node> nodes_;  // the root is 1; 0 is unused
};

}  // namespace etendue
