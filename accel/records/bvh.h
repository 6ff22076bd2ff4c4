// Bounding volume hierarchy of spheres that grows sphere by sphere: an R-tree ([Guttman1984]) with eight boxes or spheres to a
// node. All leaves lie on one level, so that depth stays logarithmic whatever is inserted in whatever order.
//
// A sphere descends to the child whose box grows least by it. A node that overflows is cut in two where, of all cuts along the
// three axes, the margins of the two boxes add up to least ([Beckmann1990]); the margin, the sum of a box's edges, is defined
// for flat and for huge boxes where an area is zero or overflows. Boxes are wider than their spheres by what rounding may err.
// Spheres with radii above 1e30 are tested one by one.
#pragma once

#include "accel/records/record_sphere.h"

#include <array>

namespace etendue {

class RecordBvh {
 public:
  void insert(const vec3& centre, float radius, std::uint32_t id);
  void covering(const vec3& p, Neighbours& out) const;
  std::uint64_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node) + everywhere_.size() * sizeof(RecordSphere);
  }

 private:
  static constexpr std::uint32_t width = 8, fewest = 3;  // entries of a node, and of one that a cut leaves

  // The first `count` of its entries are in use; the others cover nothing.
  struct Leaf {
    float centre[3][width];
    float radius_squared[width];
    float radius[width];
    std::uint32_t id[width];
    std::uint32_t count = 0;
    Leaf();
  };
  struct Node {
    float lower[3][width], upper[3][width];
    std::uint32_t child[width];  // of nodes_, or of leaves_ on the lowest level
    std::uint32_t count = 0;
    Node();
  };
  struct Entry {  // of a node that is cut
    Bounds box;
    RecordSphere sphere;
    std::uint32_t child = no_id;
  };
  using Overflow = std::array<Entry, width + 1>;

  static Bounds box_of(const RecordSphere& sphere);
  static Bounds box_of(const Leaf& leaf);
  static Bounds box_of(const Node& node);
  static void put(Leaf& leaf, std::uint32_t i, const Entry& entry);
  static void put(Node& node, std::uint32_t i, const Entry& entry);
  static Entry get(const Leaf& leaf, std::uint32_t i);
  static Entry get(const Node& node, std::uint32_t i);
  static std::uint32_t best_cut(Overflow& entries);
  static std::uint32_t best_child(const Node& node, const Bounds& box);
  template <class Kind>
  static std::uint32_t add(std::vector<Kind>& all, std::uint32_t index, const Entry& entry);

  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;
  std::uint32_t root_ = 0, height_ = 0;  // levels of nodes; 0: the root is a leaf
  std::vector<RecordSphere> everywhere_;
};

}  // namespace etendue
