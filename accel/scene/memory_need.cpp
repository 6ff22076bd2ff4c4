#include "accel/scene/memory_need.h"

#include "accel/bvh/layout_binary.h"
#include "accel/bvh/wide/wide_tree.h"
#include "accel/kernels/leaf.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// Any geometry needs this much, whatever it holds, since nodes and leaves are not divisible.
constexpr double least = 4096;

// Bytes of what is built from, or into.
constexpr double item = sizeof(BuildItem), tree_node = sizeof(TreeNode), id = sizeof(std::uint32_t),
                 binary_node = BinaryLayout::node_bytes, pack_of_four = sizeof(Leaves::Pack);

constexpr double list_growth = 2;  // of a vector that grows by doubling, over what it holds; while it moves, 3 times

MemoryNeed whole(const Geometry& geometry, double kept, double peak) {
  if (geometry.primitive_count() == 0) return {};
  return {static_cast<std::uint64_t>(std::ceil(kept + least)), static_cast<std::uint64_t>(std::ceil(peak + 2 * least))};
}

double primitives_of(const Geometry& geometry) { return static_cast<double>(geometry.primitive_count()); }

// Triangles that share no vertex lie apart, so that leaves and packs take fewer of them.
bool is_scattered(const Geometry& geometry) {
  return static_cast<double>(geometry.positions.size()) > 2.5 * primitives_of(geometry);
}

// Primitives of a leaf on average, where leaves may take so many.
double filling(double leaf_size, const Geometry& geometry) {
  return std::max(1.0, (is_scattered(geometry) ? 0.6 : 0.65) * leaf_size);
}

// Large arrays lie on whole pages of 2 MiB (framework/core/huge_pages.h).
constexpr double huge_page = 2 << 20;

double on_pages(double bytes) { return bytes < huge_page ? bytes : std::ceil(bytes / huge_page + 1) * huge_page; }

struct WideShape {
  double node, pack;           // bytes
  double children, triangles;  // in them on average
  double tree_leaf;            // most primitives of a leaf of the binary tree it is collapsed from
};

// A pack of bvh16 holds 16 vertices: six triangles and more of a mesh, five that share none, and three of those that lie apart,
// or two where reinsertion cut the tree to single ones first.
WideShape shape_of(const std::string& layout, const Geometry& geometry, bool reinsertion = false) {
  if (layout == "bvh4") return {sizeof(WideNode<4>), sizeof(TrianglePack<4>), 3, 2.1, 1};
  if (layout == "bvh8") return {sizeof(WideNode<8>), sizeof(TrianglePack<8>), 5.5, 4, 2};
  const double vertices = static_cast<double>(geometry.positions.size()), triangles = primitives_of(geometry);
  const double filled = is_scattered(geometry) ? (reinsertion ? 2.3 : 3.3) : vertices > 1.5 * triangles ? 4.2 : 5.6;
  return {sizeof(WideNode<16>), sizeof(SharedPack), 11, filled, 5};
}

double plan_bytes(const std::string& layout) { return 16 + (layout == "bvh4" ? 4 : layout == "bvh8" ? 8 : 16); }  // per node

// The memory that build_lbvh_packs and the collapse of its tree need.
MemoryNeed to_packs_need(const Geometry& geometry, const std::string& layout) {
  const WideShape wide = shape_of(layout, geometry);
  const double count = primitives_of(geometry), packs = count / wide.triangles, inner = packs / (wide.children - 1);
  const double contents = 12 + 4 + (layout == "bvh16" ? 3 : 0) + id, keys = 8, point = 16, leaf = 24;
  const double sort = (point + 2 * keys) * count;
  const double kept = wide.node * inner + wide.pack * packs, pages = kept < huge_page ? 0 : huge_page;
  const double ready = wide.pack * packs + (2 * tree_node + 5) * packs;          // packs, their tree, counts and areas
  const double least_filling = layout == "bvh4" ? 2 : layout == "bvh8" ? 3 : 4;  // of PackCutter
  const double cut = (point + keys + contents + (2 * tree_node + leaf) / least_filling) * count + ready + pages;
  const double collapse = ready + 2 * plan_bytes(layout) * packs + pages + (1 + list_growth) * wide.node * inner;
  return whole(geometry, kept, 1.1 * std::max({sort, cut, collapse}));
}

}  // namespace

MemoryNeed bvh_need(const Geometry& geometry, const std::string& layout, int leaf_size, bool reinsertion,
                    const BuilderSpace& builder) {
  const double count = primitives_of(geometry), references = count * builder.references;
  const bool binary = layout == "binary";
  if (builder.to_packs && !binary && leaf_size == 0 && !reinsertion && geometry.quadrics.empty())
    return to_packs_need(geometry, layout);
  const WideShape wide = shape_of(layout, geometry, reinsertion);
  const double tree_leaf = !binary ? (reinsertion ? 1 : wide.tree_leaf) : leaf_size > 0 ? leaf_size : 4;
  const double nodes = 2 * references / filling(tree_leaf, geometry);
  // Builders lay out two places per primitive and move the nodes together where leaves hold several.
  const double tree = tree_node * nodes + id * references;
  double peak = on_pages(item * count) + on_pages(2 * tree_node * references) + id * references +
                on_pages(builder.per_primitive * references) + (tree_node + id) * nodes;
  if (reinsertion) peak = std::max(peak, 2 * tree + 64 * nodes);  // moves, parents, and the tree in its new order
  double kept = 0;
  if (binary) {
    const double leaves = references / filling(tree_leaf, geometry), packs = leaves * std::max(1.0, 0.3 * tree_leaf);
    kept = binary_node * leaves + pack_of_four * packs;
    peak = std::max(peak, tree + kept + list_growth * pack_of_four * packs + id * nodes);
  } else {
    const double triangles = leaf_size > 0 ? std::min<double>(leaf_size, wide.triangles) : wide.triangles;
    const double packs = references / triangles, inner = packs / (wide.children - 1);
    kept = wide.node * inner + wide.pack * packs;
    const double plan = plan_bytes(layout) * nodes + 16 * references;
    const double vertices = 20.0 * static_cast<double>(geometry.positions.size());  // told apart by position
    peak = std::max(peak + vertices, tree + plan + vertices + on_pages(wide.pack * packs) +
                                         on_pages((1 + list_growth) * wide.node * inner) + list_growth * id * packs);
  }
  return whole(geometry, kept, 1.1 * peak);  // stacks and tasks
}

MemoryNeed brute_need(const Geometry& geometry) {
  const double kept = pack_of_four * primitives_of(geometry) / Leaves::Pack::lanes;
  return whole(geometry, kept, kept + list_growth * kept + list_growth * id * primitives_of(geometry));
}

MemoryNeed in_place_need(const Geometry&) { return {}; }

MemoryNeed grid_need(const Geometry& geometry, double density, int max_cells) {
  const double count = primitives_of(geometry), cells = std::min(density * count, static_cast<double>(max_cells));
  const double kept = id * cells + id * (3 * count + 1.5 * cells);
  return whole(geometry, kept, kept + id * cells + list_growth * id * count);
}

MemoryNeed kd_tree_need(const Geometry& geometry) {
  const double count = primitives_of(geometry), kept = 100 * count;
  return whole(geometry, kept, list_growth * kept + 150 * count);
}

MemoryNeed octree_need(const Geometry& geometry) {
  const double count = primitives_of(geometry), references = 9 * count, kept = id * references + 26 * count;
  return whole(geometry, kept, kept + list_growth * kept + list_growth * id * references);
}

MemoryNeed embree_need(const Geometry& geometry, const std::string& quality) {
  const double count = primitives_of(geometry);
  const double kept = (quality == "high" ? 180 : 120) * count + 16.0 * static_cast<double>(geometry.positions.size());
  MemoryNeed need = whole(geometry, kept, kept + (quality == "high" ? 120 : 80) * count);
  if (need.kept > 0) {  // its own arenas and threads
    need.kept += 64 << 10;
    need.peak += 256 << 10;
  }
  return need;
}

MemoryNeed cgal_need(const Geometry& geometry) {
  const double kept = 88 * primitives_of(geometry);
  return whole(geometry, kept, 2 * kept);
}

MemoryNeed scene_need(const Scene& scene, const std::function<MemoryNeed(const Geometry&)>& need) {
  MemoryNeed sum;
  std::uint64_t working = 0;
  const std::size_t objects = scene.has_instances() ? scene.objects.size() : 1;
  for (std::size_t i = 0; i < objects; ++i) {
    const MemoryNeed own = need(scene.objects[i].geometry);
    sum.kept += own.kept;
    working = std::max(working, own.peak - own.kept);
  }
  if (scene.has_instances()) {  // transforms, the nodes above them, and what these are built from
    sum.kept += 240 * scene.instances.size();
    working = std::max<std::uint64_t>(working, 300 * scene.instances.size());
  }
  sum.kept += scene.planes.size() * sizeof(InfinitePlane);
  sum.peak = sum.kept + working;
  return sum;
}

}  // namespace etendue
