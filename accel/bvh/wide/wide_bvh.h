// Bounding volume hierarchy over one geometry: any builder's tree in a wide layout, traversed with the instruction
// set that is chosen as it is built (framework/core/isa.h).
#pragma once

#include "accel/bvh/wide/small_geometry.h"
#include "accel/bvh/wide/wide_tree.h"
#include "accel/kernels/box_test.h"
#include "framework/core/isa.h"
#include "framework/query.h"

#include <algorithm>
#include <span>

namespace etendue {

template <int node_width, class Pack>
struct WideView {
  const WideTree<node_width, Pack>& tree;
  const Geometry& geometry;
  float extent;  // largest_coordinate of the root's box
  const SmallGeometry& small;
};

// A ray against a leaf that takes more than SIMD instructions: a list of primitives, or a pack of which some triangle takes
// double precision. It lowers `hit`; for `any_hit` the first that is found will do. Compiled once for all instruction sets,
// and out of line: what is called from the midst of a loop keeps the loop's vectors out of registers.
template <int node_width, class Pack>
bool test_rare_leaf(const WideView<node_width, Pack>& view, const Ray& ray, const TriangleRay& shear, WideRef leaf,
                    bool any_hit, Hit& hit);

template <int node_width, class Pack>
struct WideKernels {
  using View = WideView<node_width, Pack>;

  Hit (*closest)(const View&, const Ray&);
  bool (*occluded)(const View&, const Ray&);
  void (*closest_of)(const View&, std::span<const Ray>, std::span<Hit>);
  void (*occluded_of)(const View&, std::span<const Ray>, std::span<bool>);
  Hit (*closest_counted)(const View&, const Ray&, TraversalCounters&);
  bool (*occluded_counted)(const View&, const Ray&, TraversalCounters&);
};

// The traversal is compiled for each instruction set in a file of its own (wide_isa_*.cpp). All give the same bits.
template <int node_width, class Pack>
const WideKernels<node_width, Pack>& wide_kernels(Isa isa);

template <int node_width, class Pack>
class WideBvh {
 public:
  // A binary tree need not be built further down than to this many primitives: a finer one would give about as many packs.
  static constexpr int tree_leaf_size = Pack::lanes == 16 ? 5 : Pack::lanes / 4;

  using LeafPack = Pack;

  // The geometry must outlive the structure (its quadrics are looked up; triangles are copied).
  WideBvh(const VertexIds& vertices, const BinaryTree& tree, const CollapseOptions& options = {}, Isa isa = chosen_isa())
      : WideBvh(vertices.geometry(), tree, collapse<node_width, Pack>(vertices, tree, options), isa) {}
  WideBvh(const Geometry& geometry, PackTree<Pack> packs, Isa isa = chosen_isa())
      : WideBvh(geometry, packs.tree, collapse<node_width, Pack>(std::move(packs)), isa) {}

  Hit closest(const Ray& ray) const { return kernels_->closest(view(), ray); }
  bool occluded(const Ray& ray) const { return kernels_->occluded(view(), ray); }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const { kernels_->closest_of(view(), rays, hits); }
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const { kernels_->occluded_of(view(), rays, occluded); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const {
    return kernels_->closest_counted(view(), ray, counters);
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const {
    return kernels_->occluded_counted(view(), ray, counters);
  }
  RayStructureStats stats() const {
    std::uint64_t references = tree_.list_ids.size();
    for (const Pack& pack : tree_.packs) references += Pack::lanes - std::count(pack.ids, pack.ids + Pack::lanes, no_id);
    return {tree_.bytes() + small_.bytes(), tree_.nodes.size(), tree_.depth, references, tree_.sah_cost, layout_name};
  }

 private:
  WideBvh(const Geometry& geometry, const BinaryTree& tree, WideTree<node_width, Pack> wide, Isa isa)
      : geometry_(&geometry),
        tree_(std::move(wide)),
        kernels_(&wide_kernels<node_width, Pack>(isa)),
        extent_(tree.nodes.empty() ? 0 : largest_coordinate(tree.nodes[0].bounds)),
        small_(isa >= Isa::avx2 ? SmallGeometry(geometry) : SmallGeometry()) {}

  WideView<node_width, Pack> view() const { return {tree_, *geometry_, extent_, small_}; }

  static constexpr const char* layout_name = node_width == 4 ? "bvh4" : node_width == 8 ? "bvh8" : "bvh16";

  const Geometry* geometry_;
  WideTree<node_width, Pack> tree_;
  const WideKernels<node_width, Pack>* kernels_;
  float extent_;
  SmallGeometry small_;  // where batches are asked of all of it
};

using Bvh4 = WideBvh<4, TrianglePack<4>>;
using Bvh8 = WideBvh<8, TrianglePack<8>>;
using Bvh16 = WideBvh<16, SharedPack>;

}  // namespace etendue
