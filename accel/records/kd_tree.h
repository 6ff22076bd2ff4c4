// kd-trees over the centres of spheres ([Bentley1975]), each node with the largest radius below it: a subtree is left out where
// its plane is farther than that.
//
// kd-trees do not grow well, so there are several, each over twice as many spheres as the one before, and a few spheres in a
// list ([Bentley1980]'s logarithmic method). When the list is full, it and all trees up to the first that is missing become
// that one. A sphere is thus rebuilt into a tree once for each doubling: insertion is cheap on average, but some take as long
// as rebuilding everything. One large sphere causes visits of its ancestors' siblings too: this structure suits radii of
// similar size.
//
// The trees are left-balanced, in heap order ([Jensen2001]). Pruning takes the float operations of the answer itself, rounding
// is monotone, and so it is exact without slack.
#pragma once

#include "accel/records/record_sphere.h"

namespace etendue {

class RecordKdTree {
 public:
  void insert(const vec3& centre, float radius, std::uint32_t id);
  void covering(const vec3& p, Neighbours& out) const;
  std::uint64_t bytes() const;

 private:
  static constexpr std::size_t list_size = 32;

  struct Node {
    RecordSphere sphere;
    float largest_radius;  // in its subtree
    int axis;
  };
  using Tree = std::vector<Node>;  // the root is 1, the children of i are 2i and 2i + 1; empty, or list_size 2^i spheres

  static float place(std::span<RecordSphere> spheres, std::size_t node, Tree& tree);
  static void ask(const Tree& tree, const vec3& p, Neighbours& out);

  std::vector<RecordSphere> list_;
  std::vector<Tree> trees_;
};

}  // namespace etendue
