#include "accel/registry.h"

#include "accel/ball/brute_force.h"
#include "accel/ball/bvh.h"
#include "accel/ball/cells.h"
#include "accel/ball/hash_grid.h"
#include "accel/ball/kd_tree.h"
#include "accel/ball/octree.h"
#include "accel/memory_ladder.h"
#include "accel/memory_need.h"
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
#include "accel/ray/build_lbvh_packs.h"
#include "accel/ray/build_median.h"
#include "accel/ray/build_median_rotating.h"
#include "accel/ray/build_midpoint.h"
#include "accel/ray/build_ploc.h"
#include "accel/ray/build_sah.h"
#include "accel/ray/build_sbvh.h"
#include "accel/ray/bvh.h"
#include "accel/ray/cgal.h"
#include "accel/ray/embree.h"
#include "accel/ray/grid.h"
#include "accel/ray/kd_tree.h"
#include "accel/ray/mesh_bounds.h"
#include "accel/ray/octree.h"
#include "accel/ray/pack_test.h"
#include "accel/ray/reinsertion.h"
#include "accel/ray/two_level.h"
#include "accel/ray/wide_bvh.h"
#include "accel/ray/with_planes.h"
#include "framework/core/error.h"

#include <tbb/parallel_invoke.h>

#include <optional>

namespace etendue {

namespace {

template <RayStructure S>
std::unique_ptr<RayQuery> behind_interface(S structure, const Scene& scene) {
  if (scene.planes.empty()) return std::make_unique<RayAdapter<S>>(std::move(structure));
  return std::make_unique<RayAdapter<WithPlanes<S>>>(WithPlanes<S>(std::move(structure), scene.planes));
}

// Most structures ask for an object's geometry alone.
template <class MakeBottom>
auto make_over(const MakeBottom& make_bottom, const Object& object) {
  if constexpr (std::invocable<const MakeBottom&, const Object&>)
    return make_bottom(object);
  else
    return make_bottom(object.geometry);
}

// A whole scene with no more around the structure than it needs: a second level only over instances, planes only where there
// are any. `make_bottom(geometry)` builds over one object, `make_top(items)` the tree over instances.
template <class MakeBottom, class MakeTop>
std::unique_ptr<RayQuery> over_scene(const Scene& scene, MemoryWatch* watch, const MakeBottom& make_bottom,
                                     const MakeTop& make_top) {
  if (!scene.has_instances()) return behind_interface(make_over(make_bottom, scene.objects[0]), scene);
  std::vector<decltype(make_over(make_bottom, scene.objects[0]))> bottoms;
  for (const Object& object : scene.objects) {
    bottoms.push_back(make_over(make_bottom, object));
    if (watch != nullptr) watch->keep(bottoms.back().stats().bytes);
  }
  return behind_interface(TwoLevel(std::move(bottoms), scene, make_top(instance_items(scene))), scene);
}

template <class Params>
WithMemory<Params> read_with_memory(const ParamMap& map, const char* name) {
  return read_params<WithMemory<Params>>(map, name);
}

// The parameters as a structure takes them that is built under a watch, perhaps null.
template <class Params>
Params read_watched(const ParamMap& map, const char* name, const MemoryWatch* watch) {
  Params params = read_with_memory<Params>(map, name);
  if constexpr (requires { params.watch; }) params.watch = watch;
  return params;
}

// What a builder takes, and how its trees are to lie in memory.
template <class BuilderParams>
struct BvhParams : BuilderParams {
  std::string layout = "binary";
  int reinsertion = 0;

  BvhParams() { this->leaf_size = 0; }
};

template <class Visitor, class BuilderParams>
void describe(Visitor& v, BvhParams<BuilderParams>& params) {
  describe(v, static_cast<BuilderParams&>(params));
  v.choice("layout", params.layout, {"binary", "wide4", "wide8", "wide16", "auto"},
           "nodes of two children; or of 4, 8 or 16, with SIMD packs of triangles as leaves; or what suits scene and machine");
  v.integer("reinsertion", params.reinsertion, 0, 100, "passes",
            "of optimisation, at most: subtrees put where they cost least");
}

// Bottom levels in a wide layout. For a quick build the tree goes down to what a pack takes; for an optimised one, to single
// primitives, of which the collapse makes the leaves.
template <class Wide, class Params, class Build>
std::unique_ptr<RayQuery> wide_over_scene(const Scene& scene, const Params& params, MemoryWatch* watch, const Build& build) {
  CollapseOptions options;
  if (params.leaf_size > 0) options.leaf_size = static_cast<std::uint32_t>(params.leaf_size);
  if constexpr (requires { params.primitive_cost; }) options.leaf_cost = 1.5f * params.primitive_cost;  // of a whole pack
  Params fine = params, single = params;
  single.leaf_size = 1;
  fine.leaf_size = params.reinsertion > 0 ? 1 : Wide::tree_leaf_size;
  if (params.leaf_size > 0) fine.leaf_size = std::min(fine.leaf_size, params.leaf_size);
  if constexpr (requires { fine.primitive_cost; }) fine.primitive_cost = 0;  // so many are a leaf in any case
  const bool to_packs = params.leaf_size == 0 && params.reinsertion == 0;
  return over_scene(
      scene, watch,
      [&](const Geometry& geometry) {
        if constexpr (std::derived_from<Params, LbvhParams>)
          if (to_packs)
            if (const auto packs = build_lbvh_packs<typename Wide::LeafPack>(geometry, fine))
              return Wide(geometry, packs->tree, packs->contents,
                          CollapseOptions{.leaves_are_packs = true, .each_is_a_pack = true});
        std::optional<VertexIds> vertices;
        std::vector<BuildItem> items;
        tbb::parallel_invoke([&] { vertices.emplace(geometry); }, [&] { items = build_items(geometry); });
        const PackTest packs = PackTest::of<typename Wide::LeafPack>(*vertices);
        Params limits = fine;
        if (to_packs) limits.packs = &packs;
        const BinaryTree tree = build(std::move(items), limits, &geometry);
        CollapseOptions collapse = options;
        collapse.leaves_are_packs = to_packs && static_cast<int>(tree.depth) < limits.max_depth;
        return Wide(*vertices, tree, collapse);
      },
      [&](std::vector<BuildItem> items) { return build(std::move(items), single, nullptr); });
}

// What traces fastest: the widest that the machine's instructions serve, but sixteen children only for meshes and for so few
// triangles that they mostly fit in a few packs, which are tested whole (between them, some primitives are two or three visits
// in any layout, and a narrower node is the cheaper visit).
std::string resolved_layout(const std::string& layout, const Scene& scene) {
  if (layout != "auto") return layout;
  constexpr std::uint32_t few = 48, mesh = 4096;
  std::uint32_t largest = 0;
  for (const Object& object : scene.objects) largest = std::max(largest, object.geometry.primitive_count());
  const Isa isa = supported_isas().back();
  return isa == Isa::avx512 && (largest <= few || largest >= mesh) ? "wide16" : isa >= Isa::avx2 ? "wide8" : "binary";
}

// A row of the table for a builder; its instances' tree is of the same builder, and binary. `space(params)`: what it takes.
template <class BuilderParams, class Space>
RayEntry bvh_entry(const char* name, const char* summary, const Space& space,
                   BinaryTree (*build_tree)(std::vector<BuildItem>, const BuilderParams&, const Geometry*)) {
  using Params = BvhParams<BuilderParams>;
  const auto build = [build_tree](std::vector<BuildItem> items, const Params& params, const Geometry* geometry) {
    BinaryTree tree = build_tree(std::move(items), params, geometry);
    reinsert_subtrees(tree, params.reinsertion);
    return tree;
  };
  const auto binary_params = [name](const ParamMap& map) {
    auto params = read_watched<Params>(map, name, nullptr);
    if (params.leaf_size == 0) params.leaf_size = TreeLimits().leaf_size;
    return params;
  };
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<Params>>()};
  entry.need = [=](const Scene& scene, const ParamMap& map) {
    const auto params = read_watched<Params>(map, name, nullptr);
    return scene_need(scene, [&](const Geometry& geometry) {
      return bvh_need(geometry, resolved_layout(params.layout, scene), params.leaf_size, params.reinsertion > 0, space(params));
    });
  };
  entry.build = [=, need = entry.need](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    auto params = read_watched<Params>(map, name, watch);
    if constexpr (requires { params.bytes_per_reference; }) {
      double references = 0;
      for (const Object& object : scene.objects) references += space(params).references * object.geometry.primitive_count();
      if (watch != nullptr && references > 0)
        params.bytes_per_reference = static_cast<std::uint64_t>(static_cast<double>(need(scene, map).peak) / references);
    }
    const std::string layout = resolved_layout(params.layout, scene);
    if (layout == "wide4") return wide_over_scene<Wide4Bvh>(scene, params, watch, build);
    if (layout == "wide8") return wide_over_scene<Wide8Bvh>(scene, params, watch, build);
    if (layout == "wide16") return wide_over_scene<Wide16Bvh>(scene, params, watch, build);
    if (params.leaf_size == 0) params.leaf_size = TreeLimits().leaf_size;
    return over_scene(
        scene, watch, [&](const Geometry& geometry) { return Bvh(geometry, build(build_items(geometry), params, &geometry)); },
        [&](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); });
  };
  entry.tree = [=](const Geometry& geometry, const ParamMap& map) {
    return build(build_items(geometry), binary_params(map), &geometry);
  };
  entry.builder = [=](const ParamMap& map) -> TreeBuilder {
    const auto params = binary_params(map);
    if (params.layout != "binary" && params.layout != "auto")
      throw Error(map.at("layout").where,
                  std::string(name) + ": layout '" + params.layout + "' cannot change over time; expected binary");
    if (const auto budget = read_with_memory<Params>(map, name).budget; budget.memory > 0)
      throw Error(map.at("memory").where,
                  std::string(name) + ": trees that change over time take no memory budget; expected none");
    return [params, build](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); };
  };
  return entry;
}

// A builder that sees boxes only, and what it takes per primitive.
template <class BuilderParams, BinaryTree (*build)(std::vector<BuildItem>, const BuilderParams&)>
RayEntry bvh_entry(const char* name, const char* summary, double bytes_per_primitive) {
  return bvh_entry<BuilderParams>(
      name, summary, [=](const BuilderParams&) { return BuilderSpace{bytes_per_primitive}; },
      [](std::vector<BuildItem> items, const BuilderParams& params, const Geometry*) {
        return build(std::move(items), params);
      });
}

// Its trees hold parts of primitives, as they lie now: they cannot change over time. Few scenes use up a large duplication;
// those that do meet the watch.
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
