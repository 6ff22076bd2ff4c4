// Bounding volume hierarchy over photon spheres, queried by points ([Evangelou2021]): a photon lies within r of p where p lies
// in the sphere of radius r around the photon.
//
// Rule for the radius: the box of spheres of equal radius r is the box of their centres grown by r. So the tree holds boxes of
// centres alone, and a query grows them by its own radius as it goes; one tree serves every radius, exactly. A node is visited
// where its box of centres is within r of p by Euclidean distance, which cuts the corners that a grown box would keep. The
// distance to a box adds up as a point's does, term for term, each rounded term no larger: pruning is exact without slack.
//
// The tree is packed ([Kamel1993], with the Morton curve in the place of Hilbert's): points in curve order, eight to a leaf,
// eight nodes to a parent, level upon level, so that places are computed and no pointers are kept. It is built in
// parallel, deterministically. Coordinates should stay below 1e18.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

class SphereBvh {
 public:
  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const { find(p, r, no_limit, out); }
  bool find(const vec3& p, float r, std::size_t most, Neighbours& out) const;  // neighbourhood.h
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node); }

 private:
  static constexpr std::uint32_t width = 8;

  struct alignas(32) Leaf {
    float position[3][width];  // NaN where there is no point: never found
    std::uint32_t id[width];
  };
  // The boxes of up to eight children; NaN where there is none.
  struct alignas(32) Node {
    float lower[3][width], upper[3][width];
  };
  // A node as a query holds it; level 0 are leaves.
  struct Place {
    std::uint32_t level, index;
    float distance;  // squared, of its box
  };

  Bounds bounds_of_leaf(std::size_t leaf) const;
  static Bounds bounds_of_node(const Node& node);
  std::uint32_t root_level() const { return static_cast<std::uint32_t>(level_begin_.size() - 1); }
  const Node& node(std::uint32_t level, std::uint32_t index) const { return nodes_[level_begin_[level] + index]; }
  float first_radius(const vec3& p) const;

  std::size_t count_ = 0;
  Bounds bounds_;
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;               // level 1 first, the root last
  std::vector<std::size_t> level_begin_;  // into nodes_, by level; entry 0 is unused
};

}  // namespace etendue
