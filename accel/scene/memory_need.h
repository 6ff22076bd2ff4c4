// The memory that ray structures need (nodes, leaves, and the working space of their builders), estimated from the number of
// primitives before anything is built.
//
// Arrays of known length are counted exactly. Quantities that depend on the shape of the scene (how full leaves are, how many
// cells a triangle touches) are taken from the upper end of what scenes show, so that an estimate is seldom too low; where it
// is, the checks during and after the build remain (memory_budget.h). tests/oracle/memory_budget_test.cpp holds the estimates
// to the bytes.
#pragma once

#include "accel/scene/memory_budget.h"
#include "framework/scene/scene.h"

#include <cstdint>
#include <functional>
#include <string>

namespace etendue {

// Bytes per primitive (or reference) that a builder holds at its peak beside the boxes it is given and the tree it makes.
struct BuilderSpace {
  double per_primitive = 0;
  double references = 1;  // per primitive, in its trees
  bool to_packs = false;  // triangles go straight to the packs of a wide layout (lbvh_packs.h)
};

// `leaf_size` 0: the layout's own.
MemoryNeed bvh_need(const Geometry& geometry, const std::string& layout, int leaf_size, bool reinsertion,
                    const BuilderSpace& builder);
MemoryNeed brute_need(const Geometry& geometry);
MemoryNeed in_place_need(const Geometry& geometry);
MemoryNeed grid_need(const Geometry& geometry, double density, int max_cells);
MemoryNeed kd_tree_need(const Geometry& geometry);
MemoryNeed octree_need(const Geometry& geometry);
MemoryNeed embree_need(const Geometry& geometry, const std::string& quality);
MemoryNeed cgal_need(const Geometry& geometry);

// One structure per object, built one after another, and a tree over the instances where there are some.
MemoryNeed scene_need(const Scene& scene, const std::function<MemoryNeed(const Geometry&)>& need);

}  // namespace etendue
