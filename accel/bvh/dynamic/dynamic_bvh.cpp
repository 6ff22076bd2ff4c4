#include "accel/bvh/dynamic/dynamic_bvh.h"

#include "framework/core/parallel.h"

#include <numeric>

namespace etendue {

static_assert(RayStructure<DynamicBvh>);
static_assert(DynamicTree::leaf_size == static_cast<std::uint32_t>(Leaves::Pack::lanes));

namespace {

std::vector<Bounds> boxes_of(const Geometry& geometry, std::span<const std::uint32_t> primitives) {
  std::vector<Bounds> boxes(primitives.size());
  parallel_for(primitives.size(), update_grain, [&](std::size_t i) {
    if (geometry.is_valid(primitives[i])) boxes[i] = geometry.primitive_bounds(primitives[i]);
  });
  return boxes;
}

std::vector<Bounds> all_boxes(const Geometry& geometry) {
  std::vector<std::uint32_t> primitives(geometry.primitive_count());
  std::iota(primitives.begin(), primitives.end(), 0u);
  return boxes_of(geometry, primitives);
}

}  // namespace

DynamicBvh::DynamicBvh(const Geometry& geometry, DynamicTree::Build build, const ChangePolicy& policy)
    : geometry_(&geometry), tree_(all_boxes(geometry), std::move(build), policy), leaves_(geometry) {
  fill_touched_leaves();
}

TreeUpdate DynamicBvh::update(std::span<const std::uint32_t> changed) {
  const TreeUpdate done = tree_.update(changed, boxes_of(*geometry_, changed));
  fill_touched_leaves();
  return done;
}

void DynamicBvh::fill_touched_leaves() {
  leaves_.resize(tree_.leaf_count());
  const std::span<const std::uint32_t> touched = tree_.touched();
  parallel_for(touched.size(), update_grain, [&](std::size_t i) {
    std::array<std::uint32_t, DynamicTree::leaf_size> items;
    const std::uint32_t count = tree_.present_items(touched[i], items);
    leaves_.set(touched[i], std::span(items).first(count));
  });
}

RayStructureStats DynamicBvh::stats() const {
  const BinaryLayout& layout = tree_.layout();
  return {
      tree_.bytes() + leaves_.bytes(), layout.node_count(), layout.depth(), leaves_.references(), tree_.sah_cost(), "binary"};
}

}  // namespace etendue
