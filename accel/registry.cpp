#include "accel/registry.h"

#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/lbvh.h"
#include "accel/bvh/build/median.h"
#include "accel/bvh/build/median_round_robin.h"
#include "accel/bvh/build/midpoint.h"
#include "accel/bvh/build/ploc.h"
#include "accel/bvh/build/sah.h"
#include "accel/bvh/build/sbvh.h"
#include "accel/points/brute_force.h"
#include "accel/points/hash_grid.h"
#include "accel/points/left_balanced_tree.h"
#include "accel/points/nanoflann_tree.h"
#include "accel/points/sorted_grid.h"
#include "accel/points/sphere_bvh.h"
#include "accel/records/brute_force.h"
#include "accel/records/bvh.h"
#include "accel/records/cells.h"
#include "accel/records/hash_grid.h"
#include "accel/records/kd_tree.h"
#include "accel/records/octree.h"
#include "accel/scene/auto_structure.h"
#include "accel/spatial/brute_force.h"
#include "accel/spatial/grid.h"
#include "accel/spatial/kd_tree.h"
#include "accel/spatial/mesh_bounds.h"
#include "accel/spatial/octree.h"
#include "accel/thirdparty/cgal.h"
#include "accel/thirdparty/embree.h"
#include "framework/core/error.h"

namespace etendue {

namespace {

template <PointStructure S>
PointEntry point_entry(const char* name, const char* summary) {
  return {name, summary, [] { return std::make_unique<PointAdapter<S>>(S()); }};
}

template <RecordStructure S>
RecordEntry record_entry(const char* name, const char* summary) {
  return {name, summary, [](const Bounds&) { return std::make_unique<RecordAdapter<S>>(S()); }};
}

template <class Entry>
const Entry& find(std::span<const Entry> entries, const char* kind, const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const Entry& entry : entries) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw Error(where, unknown_name(kind, name, names));
}

}  // namespace

bool is_adapter(std::string_view label) { return label.starts_with("embree") || label.starts_with("cgal"); }

std::span<const RayEntry> ray_structures() {
  static const std::vector<RayEntry> entries{
      brute_entry(),    bounds_entry(), median_entry(),     median_round_robin_entry(),
      midpoint_entry(), sah_entry(),    binned_sah_entry(), sbvh_entry(),
      lbvh_entry(),     ploc_entry(),   grid_entry(),       kd_tree_entry(),
      octree_entry(),   embree_entry(), cgal_entry(),       auto_structure_entry(),
  };
  return entries;
}

std::span<const PointEntry> point_structures() {
  static const std::vector<PointEntry> entries{
      point_entry<PointBruteForce>("brute", "every point for every query: the measure of the others"),
      point_entry<NanoflannTree>("nanoflann", "nanoflann's kd-tree, with buckets"),
      point_entry<LeftBalancedTree>("kd-tree", "left-balanced kd-tree, a point in each node, in heap order"),
      point_entry<HashGrid>("hash-grid", "uniform grid, its cells folded into a table by a hash"),
      point_entry<SortedGrid>("sorted-grid", "rows of a grid in two dimensions, sorted along the third"),
      point_entry<SphereBvh>("bvh", "boxes around spheres about the points, eight by eight along the Morton curve"),
  };
  return entries;
}

std::span<const RecordEntry> record_structures() {
  static const std::vector<RecordEntry> entries{
      record_entry<RecordBruteForce>("brute", "every record for every query: the measure of the others"),
      {"octree", "each record in an octree cell of about its size",
       [](const Bounds& bounds) { return std::make_unique<RecordAdapter<RecordOctree>>(RecordOctree(bounds)); }},
      record_entry<RecordHashGrid>("hash-grid", "a hashed grid for each size, each record in the cells it touches"),
      record_entry<RecordKdTree>("kd-tree", "kd-trees over the centres, rebuilt in doubling sizes"),
      record_entry<RecordBvh>("bvh", "boxes around records, eight by eight (R-tree)"),
      {"cells", "cells that list every record which touches them, cut where that tells records apart",
       [](const Bounds& bounds) { return std::make_unique<RecordAdapter<RecordCells>>(RecordCells(bounds)); }},
  };
  return entries;
}

const RayEntry& find_ray_structure(const std::string& name, const Location& where) {
  const RayEntry& entry = find(ray_structures(), "ray structure", name, where);
  if (!entry.available)
    throw Error(where, "structure '" + name + "' is not available: its library was not found when this was built");
  return entry;
}

const PointEntry& find_point_structure(const std::string& name, const Location& where) {
  return find(point_structures(), "point structure", name, where);
}

const RecordEntry& find_record_structure(const std::string& name, const Location& where) {
  return find(record_structures(), "record structure", name, where);
}

}  // namespace etendue
