// Octree of spheres ([Ward1988]): each sphere is kept once, in the cube that holds its centre and whose side is two to four
// times its radius. So it reaches out of that cube by at most half a side, and a query descends into the cubes that it lies in
// or within half a side of.
//
// The root grows (doubling towards the newcomer) for centres outside the bounds it was made for. Spheres too large for the root
// are kept at the root, which every query visits; very small ones at the depth where floats no longer tell cubes apart.
#pragma once

#include "accel/records/record_sphere.h"

#include <array>

namespace etendue {

class RecordOctree {
 public:
  explicit RecordOctree(const Bounds& bounds);

  void insert(const vec3& centre, float radius, std::uint32_t id);
  void covering(const vec3& p, Neighbours& out) const;
  std::uint64_t bytes() const { return spheres_.size() * sizeof(Listed) + nodes_.size() * sizeof(Node); }

 private:
  // Children and spheres by index; no_id: none. Child i lies above the centre on axis a where bit a of i is set.
  struct Node {
    vec3 centre;
    float half;   // of the side
    float reach;  // how far from the centre, along an axis, its spheres can extend
    std::uint32_t spheres = no_id;
    std::array<std::uint32_t, 8> children;
  };
  struct Listed {
    RecordSphere sphere;
    std::uint32_t next;
  };

  std::uint32_t add_node(const vec3& centre, float half);
  void grow_towards(const vec3& centre);
  void collect(const Node& node, const vec3& p, Neighbours& out) const;

  std::vector<Node> nodes_;
  std::vector<Listed> spheres_;
  std::uint32_t root_;
};

}  // namespace etendue
