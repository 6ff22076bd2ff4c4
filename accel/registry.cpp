#include "accel/registry.h"

#include "accel/ball/brute_force.h"
#include "accel/ball/octree.h"
#include "accel/point/brute_force.h"
#include "accel/point/hash_grid.h"
#include "accel/point/kd_tree.h"
#include "accel/ray/brute_force.h"
#include "accel/ray/build_binned_sah.h"
#include "accel/ray/build_lbvh.h"
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
#include "accel/ray/reinsertion.h"
#include "accel/ray/two_level.h"
#include "accel/ray/wide_bvh.h"
#include "accel/ray/with_planes.h"
#include "framework/core/error.h"

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
std::unique_ptr<RayQuery> over_scene(const Scene& scene, const MakeBottom& make_bottom, const MakeTop& make_top) {
  if (!scene.has_instances()) return behind_interface(make_over(make_bottom, scene.objects[0]), scene);
  std::vector<decltype(make_over(make_bottom, scene.objects[0]))> bottoms;
  for (const Object& object : scene.objects) bottoms.push_back(make_over(make_bottom, object));
  return behind_interface(TwoLevel(std::move(bottoms), scene, make_top(instance_items(scene))), scene);
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
  v.choice("layout", params.layout, {"binary", "wide4", "wide8", "wide16"},
           "nodes of two children; or of 4, 8 or 16, with SIMD packs of triangles as leaves");
  v.integer("reinsertion", params.reinsertion, 0, 100, "passes",
            "of optimisation, at most: subtrees put where they cost least");
}

// Bottom levels in a wide layout. The collapse makes the leaves: for a quick build the tree need only go down to a few
// triangles that any pack takes; for an optimised one, down to single primitives.
template <class Wide, class Params, class Build>
std::unique_ptr<RayQuery> wide_over_scene(const Scene& scene, const Params& params, const Build& build) {
  CollapseOptions options;
  if (params.leaf_size > 0) options.leaf_size = static_cast<std::uint32_t>(params.leaf_size);
  if constexpr (requires { params.primitive_cost; }) options.leaf_cost = 1.5f * params.primitive_cost;  // of a whole pack
  Params fine = params, single = params;
  single.leaf_size = 1;
  fine.leaf_size = params.reinsertion > 0 ? 1 : Wide::tree_leaf_size;
  if constexpr (requires { fine.primitive_cost; }) fine.primitive_cost = 0;  // so many are a leaf in any case
  return over_scene(
      scene, [&](const Geometry& geometry) { return Wide(geometry, build(build_items(geometry), fine, &geometry), options); },
      [&](std::vector<BuildItem> items) { return build(std::move(items), single, nullptr); });
}

// A row of the table for a builder; its instances' tree is of the same builder, and binary.
template <class BuilderParams>
RayEntry bvh_entry(const char* name, const char* summary,
                   BinaryTree (*build_tree)(std::vector<BuildItem>, const BuilderParams&, const Geometry*)) {
  using Params = BvhParams<BuilderParams>;
  const auto build = [build_tree](std::vector<BuildItem> items, const Params& params, const Geometry* geometry) {
    BinaryTree tree = build_tree(std::move(items), params, geometry);
    reinsert_subtrees(tree, params.reinsertion);
    return tree;
  };
  const auto binary_params = [name](const ParamMap& map) {
    auto params = read_params<Params>(map, name);
    if (params.leaf_size == 0) params.leaf_size = TreeLimits().leaf_size;
    return params;
  };
  const auto make = [=](const Scene& scene, const ParamMap& map) {
    auto params = read_params<Params>(map, name);
    if (params.layout == "wide4") return wide_over_scene<Wide4Bvh>(scene, params, build);
    if (params.layout == "wide8") return wide_over_scene<Wide8Bvh>(scene, params, build);
    if (params.layout == "wide16") return wide_over_scene<Wide16Bvh>(scene, params, build);
    params = binary_params(map);
    return over_scene(
        scene, [&](const Geometry& geometry) { return Bvh(geometry, build(build_items(geometry), params, &geometry)); },
        [&](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); });
  };
  const auto tree = [=](const Geometry& geometry, const ParamMap& map) {
    return build(build_items(geometry), binary_params(map), &geometry);
  };
  const auto builder = [=](const ParamMap& map) -> TreeBuilder {
    const auto params = binary_params(map);
    if (params.layout != "binary")
      throw Error(map.at("layout").where,
                  std::string(name) + ": layout '" + params.layout + "' cannot change over time; expected binary");
    return [params, build](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); };
  };
  return {name, summary, list_params<Params>(), make, true, tree, builder};
}

// A builder that sees boxes only.
template <class BuilderParams, BinaryTree (*build)(std::vector<BuildItem>, const BuilderParams&)>
RayEntry bvh_entry(const char* name, const char* summary) {
  return bvh_entry<BuilderParams>(name, summary,
                                  [](std::vector<BuildItem> items, const BuilderParams& params, const Geometry*) {
                                    return build(std::move(items), params);
                                  });
}

// Its trees hold parts of primitives, as they lie now: they cannot change over time.
RayEntry sbvh_entry() {
  RayEntry entry =
      bvh_entry<SbvhParams>("sbvh", "bounding volume hierarchy by surface area, cuts through primitives too", build_sbvh);
  entry.builder = {};
  return entry;
}

struct NoParams {};

template <class Visitor>
void describe(Visitor&, NoParams&) {}

RayEntry brute_entry() {
  const auto make = [](const Scene& scene, const ParamMap& map) {
    read_params<NoParams>(map, "brute");
    return over_scene(
        scene, [](const Geometry& geometry) { return BruteForce(geometry); }, single_leaf);
  };
  return {"brute", "every primitive for every ray: the measure of the others", list_params<NoParams>(), make};
}

RayEntry bounds_entry() {
  const auto make = [](const Scene& scene, const ParamMap& map) {
    read_params<NoParams>(map, "bounds");
    return over_scene(
        scene, [](const Object& object) { return MeshBounds(object); }, single_leaf);
  };
  return {"bounds", "a box around each mesh, and every primitive of those met", list_params<NoParams>(), make};
}

// A structure over cells of space; its instances' tree is a hierarchy of boxes.
template <class Cells, class Params>
RayEntry cells_entry(const char* name, const char* summary) {
  const auto make = [name](const Scene& scene, const ParamMap& map) {
    const auto params = read_params<Params>(map, name);
    return over_scene(
        scene, [&](const Geometry& geometry) { return Cells(geometry, params); },
        [](std::vector<BuildItem> items) { return build_sah(std::move(items), {}); });
  };
  return {name, summary, list_params<Params>(), make};
}

RayEntry embree_entry() {
#ifdef ETENDUE_HAS_EMBREE
  constexpr bool available = true;
  const auto make = [](const Scene& scene, const ParamMap& map) {
    return behind_interface(Embree(scene, read_params<EmbreeParams>(map, "embree")), scene);
  };
#else
  constexpr bool available = false;
  const auto make = [](const Scene&, const ParamMap&) -> std::unique_ptr<RayQuery> {
    throw Error("structure 'embree' is not available: this build was made without Embree 3");
  };
#endif
  return {"embree", "Intel's Embree 3, as a baseline", list_params<EmbreeParams>(), make, available};
}

RayEntry cgal_entry() {
#ifdef ETENDUE_HAS_CGAL
  constexpr bool available = true;
  const auto make = [](const Scene& scene, const ParamMap& map) {
    read_params<NoParams>(map, "cgal");
    return over_scene(
        scene, [](const Geometry& geometry) { return Cgal(geometry); },
        [](std::vector<BuildItem> items) { return build_sah(std::move(items), {}); });
  };
#else
  constexpr bool available = false;
  const auto make = [](const Scene&, const ParamMap&) -> std::unique_ptr<RayQuery> {
    throw Error("structure 'cgal' is not available: this build was made without CGAL");
  };
#endif
  return {"cgal", "CGAL's AABB tree (GPL-3), in double precision, as a baseline", list_params<NoParams>(), make, available};
}

template <PointStructure S>
PointEntry point_entry(const char* name, const char* summary) {
  return {name, summary, [] { return std::make_unique<PointAdapter<S>>(S()); }};
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
      brute_entry(),
      bounds_entry(),
      bvh_entry<TreeLimits, build_median>("median", "bounding volume hierarchy, halved at the median of centres"),
      bvh_entry<MedianRotatingParams, build_median_rotating>(
          "median-rotating", "bounding volume hierarchy, sorted and halved along x, y, z in turn"),
      bvh_entry<TreeLimits, build_midpoint>("midpoint", "bounding volume hierarchy, cut at the middle of the longest edge"),
      bvh_entry<SahParams, build_sah>("sah", "bounding volume hierarchy by surface area, every cut tried"),
      bvh_entry<BinnedSahParams, build_binned_sah>("binned-sah",
                                                   "bounding volume hierarchy by surface area, cuts between bins"),
      sbvh_entry(),
      bvh_entry<TreeLimits, build_lbvh>("lbvh", "bounding volume hierarchy, cut by the Morton codes of centres"),
      bvh_entry<PlocParams, build_ploc>("ploc", "bounding volume hierarchy, nearest neighbours along the Morton curve merged"),
      cells_entry<Grid, GridParams>("grid", "equal cells, walked one after another"),
      cells_entry<RayKdTree, KdTreeParams>("kd-tree", "space cut in two by surface area, triangles clipped"),
      cells_entry<Octree, OctreeParams>("octree", "cubes cut in eight, primitives listed in every leaf they touch"),
      embree_entry(),
      cgal_entry(),
  };
  return entries;
}

std::span<const PointEntry> point_structures() {
  static const std::vector<PointEntry> entries{
      point_entry<PointBruteForce>("brute", "every point for every query: the measure of the others"),
      point_entry<KdTree>("kd-tree", "kd-tree (nanoflann)"),
      point_entry<HashGrid>("hash-grid", "uniform grid of the occupied cells, hashed by cell"),
  };
  return entries;
}

std::span<const BallEntry> ball_structures() {
  static const std::vector<BallEntry> entries{
      {"brute", "every ball for every query: the measure of the others",
       [](const Bounds&) { return std::make_unique<BallAdapter<BallBruteForce>>(BallBruteForce()); }},
      {"octree", "each ball in an octree cell of about its size",
       [](const Bounds& bounds) { return std::make_unique<BallAdapter<BallOctree>>(BallOctree(bounds)); }},
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
