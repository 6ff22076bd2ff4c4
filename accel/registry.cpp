#include "accel/registry.h"

#include "accel/ball/brute_force.h"
#include "accel/ball/bvh.h"
#include "accel/ball/cells.h"
#include "accel/ball/hash_grid.h"
#include "accel/ball/kd_tree.h"
#include "accel/ball/octree.h"
#include "accel/bvh_entry.h"
#include "accel/memory_ladder.h"
#include "accel/memory_need.h"
#include "accel/over_scene.h"
#include "accel/point/brute_force.h"
#include "accel/point/hash_grid.h"
#include "accel/point/left_balanced_tree.h"
#include "accel/point/nanoflann_tree.h"
#include "accel/point/sorted_grid.h"
#include "accel/point/sphere_bvh.h"
#include "accel/ray/brute_force.h"
#include "accel/ray/brute_in_place.h"
#include "accel/ray/build_binned_sah.h"
#include "accel/ray/build_lbvh.h"
#include "accel/ray/build_median.h"
#include "accel/ray/build_median_rotating.h"
#include "accel/ray/build_midpoint.h"
#include "accel/ray/build_ploc.h"
#include "accel/ray/build_sah.h"
#include "accel/ray/build_sbvh.h"
#include "accel/ray/cgal.h"
#include "accel/ray/embree.h"
#include "accel/ray/grid.h"
#include "accel/ray/kd_tree.h"
#include "accel/ray/mesh_bounds.h"
#include "accel/ray/octree.h"
#include "framework/core/error.h"

namespace etendue {

namespace {

// Its trees hold parts of primitives at their present places, so they cannot change over time. Few scenes use up a large
// duplication; for those that do there is the watch.
RayEntry sbvh_entry() {
  const auto space = [](const SbvhParams& params) { return BuilderSpace{124, 1 + std::min(params.duplication, 0.5f)}; };
  RayEntry entry = bvh_entry<SbvhParams>("sbvh", "bounding volume hierarchy by surface area, cuts through primitives too",
                                         space, build_sbvh);
  entry.builder = {};
  return entry;
}

// A structure of one geometry in few lines: `make_bottom(params)` answers a maker of it, `need(geometry, params)` what it
// takes; over instances it has a tree by `make_top`.
template <class Params, class MakeBottom, class Need, class MakeTop>
RayEntry plain_entry(const char* name, const char* summary, const MakeBottom& make_bottom, const Need& need,
                     const MakeTop& make_top) {
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<Params>>()};
  entry.build = [=](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    return over_scene(scene, watch, make_bottom(read_watched<Params>(map, name, watch)), make_top);
  };
  entry.need = [=](const Scene& scene, const ParamMap& map) {
    const auto params = read_watched<Params>(map, name, nullptr);
    return scene_need(scene, [&](const Geometry& geometry) { return need(geometry, params); });
  };
  return entry;
}

BinaryTree sah_over_instances(std::vector<BuildItem> items) { return build_sah(std::move(items), {}); }
BinaryTree leaf_of_instances(std::vector<BuildItem> items) { return single_leaf(items); }

struct BruteParams {
  bool in_place = false;
};

template <class Visitor>
void describe(Visitor& v, BruteParams& params) {
  v.flag("in_place", params.in_place, "read primitives where the scene has them: no memory, but slower");
}

RayEntry brute_entry() {
  RayEntry entry{.name = "brute",
                 .summary = "every primitive for every ray: the measure of the others",
                 .params = list_params<WithMemory<BruteParams>>()};
  entry.build = [](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    if (read_watched<BruteParams>(map, "brute", watch).in_place)
      return over_scene(
          scene, watch, [](const Geometry& geometry) { return BruteInPlace(geometry); }, leaf_of_instances);
    return over_scene(
        scene, watch, [](const Geometry& geometry) { return BruteForce(geometry); }, leaf_of_instances);
  };
  entry.need = [](const Scene& scene, const ParamMap& map) {
    return scene_need(scene, read_watched<BruteParams>(map, "brute", nullptr).in_place ? in_place_need : brute_need);
  };
  return entry;
}

RayEntry bounds_entry() {
  return plain_entry<NoParams>(
      "bounds", "a box around each mesh, and every primitive of those met",
      [](const NoParams&) { return [](const Object& object) { return MeshBounds(object); }; },
      [](const Geometry& geometry, const NoParams&) { return brute_need(geometry); }, leaf_of_instances);
}

// A structure over cells of space; its instances' tree is a hierarchy of boxes.
template <class Cells, class Params, class Need>
RayEntry cells_entry(const char* name, const char* summary, const Need& need) {
  return plain_entry<Params>(
      name, summary,
      [](const Params& params) { return [params](const Geometry& geometry) { return Cells(geometry, params); }; }, need,
      sah_over_instances);
}

RayEntry embree_entry() {
  RayEntry entry{
      .name = "embree", .summary = "Intel's Embree 3, as a baseline", .params = list_params<WithMemory<EmbreeParams>>()};
#ifdef ETENDUE_HAS_EMBREE
  entry.build = [](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    return behind_interface(Embree(scene, read_watched<EmbreeParams>(map, "embree", watch)), scene);
  };
#else
  entry.available = false;
  entry.build = [](const Scene&, const ParamMap&, MemoryWatch*) -> std::unique_ptr<RayQuery> {
    throw Error("structure 'embree' is not available: this build was made without Embree 3");
  };
#endif
  entry.need = [](const Scene& scene, const ParamMap& map) {
    const auto params = read_watched<EmbreeParams>(map, "embree", nullptr);
    return scene_need(scene, [&](const Geometry& geometry) { return embree_need(geometry, params.quality); });
  };
  return entry;
}

RayEntry cgal_entry() {
  const char* const name = "cgal";
  const char* const summary = "CGAL's AABB tree (GPL-3), in double precision, as a baseline";
  const auto need = [](const Geometry& geometry, const NoParams&) { return cgal_need(geometry); };
#ifdef ETENDUE_HAS_CGAL
  return plain_entry<NoParams>(
      name, summary, [](const NoParams&) { return [](const Geometry& geometry) { return Cgal(geometry); }; }, need,
      sah_over_instances);
#else
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<NoParams>>(), .available = false};
  entry.build = [](const Scene&, const ParamMap&, MemoryWatch*) -> std::unique_ptr<RayQuery> {
    throw Error("structure 'cgal' is not available: this build was made without CGAL");
  };
  entry.need = [need](const Scene& scene, const ParamMap&) {
    return scene_need(scene, [&](const Geometry& geometry) { return need(geometry, {}); });
  };
  return entry;
#endif
}

// Gives every structure its budget.
std::vector<RayEntry> with_budgets(std::vector<RayEntry> entries) {
  for (RayEntry& entry : entries)
    entry.make = [name = entry.name](const Scene& scene, const ParamMap& map) {
      return make_within_memory(find_ray_structure(name, {}), scene, map);
    };
  return entries;
}

template <PointStructure S>
PointEntry point_entry(const char* name, const char* summary) {
  return {name, summary, [] { return std::make_unique<PointAdapter<S>>(S()); }};
}

template <BallStructure S>
BallEntry ball_entry(const char* name, const char* summary) {
  return {name, summary, [](const Bounds&) { return std::make_unique<BallAdapter<S>>(S()); }};
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
  static const std::vector<RayEntry> entries = with_budgets({
      brute_entry(),
      bounds_entry(),
      bvh_entry<TreeLimits, build_median>("median", "bounding volume hierarchy, halved at the median of centres", 20),
      bvh_entry<MedianRotatingParams, build_median_rotating>(
          "median-rotating", "bounding volume hierarchy, sorted and halved along x, y, z in turn", 44),
      bvh_entry<TreeLimits, build_midpoint>("midpoint", "bounding volume hierarchy, cut at the middle of the longest edge", 64),
      bvh_entry<SahParams, build_sah>("sah", "bounding volume hierarchy by surface area, every cut tried", 44),
      bvh_entry<BinnedSahParams, build_binned_sah>("binned-sah", "bounding volume hierarchy by surface area, cuts between bins",
                                                   64),
      sbvh_entry(),
      bvh_entry<LbvhParams, build_lbvh>("lbvh", "bounding volume hierarchy, cut by the Morton codes of centres", 60),
      bvh_entry<PlocParams, build_ploc>("ploc", "bounding volume hierarchy, nearest neighbours along the Morton curve merged",
                                        120),
      cells_entry<Grid, GridParams>("grid", "equal cells, walked one after another",
                                    [](const Geometry& geometry, const GridParams& params) {
                                      return grid_need(geometry, params.density, params.max_cells);
                                    }),
      cells_entry<RayKdTree, KdTreeParams>(
          "kd-tree", "space cut in two by surface area, triangles clipped",
          [](const Geometry& geometry, const KdTreeParams&) { return kd_tree_need(geometry); }),
      cells_entry<Octree, OctreeParams>("octree", "cubes cut in eight, primitives listed in every leaf they touch",
                                        [](const Geometry& geometry, const OctreeParams&) { return octree_need(geometry); }),
      embree_entry(),
      cgal_entry(),
  });
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

std::span<const BallEntry> ball_structures() {
  static const std::vector<BallEntry> entries{
      ball_entry<BallBruteForce>("brute", "every ball for every query: the measure of the others"),
      {"octree", "each ball in an octree cell of about its size",
       [](const Bounds& bounds) { return std::make_unique<BallAdapter<BallOctree>>(BallOctree(bounds)); }},
      ball_entry<BallHashGrid>("hash-grid", "a hashed grid for each size, each ball in the cells it touches"),
      ball_entry<BallKdTree>("kd-tree", "kd-trees over the centres, rebuilt in doubling sizes"),
      ball_entry<BallBvh>("bvh", "boxes around balls, eight by eight (R-tree)"),
      {"cells", "cells that list every ball which touches them, cut where that tells balls apart",
       [](const Bounds& bounds) { return std::make_unique<BallAdapter<BallCells>>(BallCells(bounds)); }},
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

const BallEntry& find_ball_structure(const std::string& name, const Location& where) {
  return find(ball_structures(), "ball structure", name, where);
}

}  // namespace etendue
