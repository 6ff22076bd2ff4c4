// Tests of single objects: claims about boxes before cylinders, and about rotated objects.
#include "accel/scene/two_level.h"
#include "accel/spatial/brute_force.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/kinds/claims/traversal_variants.h"

namespace etendue {

namespace {

using FigureKind::factor;

// A list takes each of them past every object: few will do.
std::vector<Ray> some_rays(const Scene& scene, int resolution) {
  return every_nth(record_claim_rays(scene, resolution).closest, 16384);
}

// --- a box before each quadric ---

BuildItems quadric_items(const Geometry& geometry) {
  BuildItems items;
  for (auto id = static_cast<std::uint32_t>(geometry.triangles.size()); id < geometry.primitive_count(); ++id)
    items.push_back({geometry.primitive_bounds(id), id});
  return items;
}

// Every quadric of a geometry (triangles are left out), with its box tested first or not.
class Quadrics {
 public:
  explicit Quadrics(const Geometry& geometry)
      : geometry_(geometry),
        items_(quadric_items(geometry)),
        tree_(find_ray_structure("binned-sah", {}).builder({})(items_)),
        nodes_(tree_),
        extent_(items_.empty() ? 0 : largest_coordinate(tree_.nodes[0].bounds)) {
    if (items_.empty()) throw Error("no quadric in the scene; expected cylinders or spheres");
  }

  // One after another.
  template <bool boxed>
  Hit in_a_list(const Ray& ray) const {
    return closest<boxed>(ray, [&](const auto& test, const float&, const TraversalLimit&) {
      for (const BuildItem& item : items_) test(item.id);
    });
  }
  // In the leaves of a tree.
  template <bool boxed>
  Hit in_a_tree(const Ray& ray) const {
    return closest<boxed>(ray, [&](const auto& test, const float& t_best, const TraversalLimit& limit) {
      const auto leaf = [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t i = first; i < first + count; ++i) test(tree_.primitives[i]);
      };
      Traversal<TraversalOptions{}, ScalarSlab, PackedNodes, ObserveNothing, decltype(leaf)>(nodes_, ray, limit, t_best, {},
                                                                                             leaf)
          .run(tree_.depth);
    });
  }
  Geometry alone() const { return {{}, {}, geometry_.quadrics}; }
  std::uint32_t first_id() const { return static_cast<std::uint32_t>(geometry_.triangles.size()); }

 private:
  template <bool boxed, class Visit>
  Hit closest(const Ray& ray, const Visit& visit) const {
    if (!is_traceable(ray)) return {};
    Hit hit;
    hit.t = ray.t_max;
    const ScalarSlab slab(ray);
    const TraversalLimit limit(ray, extent_);
    const auto test = [&](std::uint32_t id) {
      if constexpr (boxed) {
        if (slab.entry(items_[id - first_id()].bounds, limit(hit.t)) == infinity) return;
      }
      float t;
      vec2 uv;
      if (!intersect_quadric(ray, geometry_.quadric(id), hit.t, t, uv) || !closer(t, id, hit)) return;
      hit.t = t;
      hit.uv = uv;
      hit.primitive = id;
    };
    visit(test, hit.t, limit);
    if (!hit) return {};
    hit.instance = 0;
    hit.primitive -= first_id();
    return hit;
  }

  const Geometry& geometry_;
  BuildItems items_;
  BinaryTree tree_;
  PackedNodes nodes_;
  float extent_;
};

MeasureResult measure_cylinders(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const Quadrics quadrics(scene.objects[0].geometry);
  const std::vector<Ray> rays = some_rays(scene, task.resolution);
  Scene alone;
  alone.objects[0].geometry = quadrics.alone();
  const auto product = make_structure(alone, "binned-sah");
  MeasureResult result;
  const auto work = [&](const auto& closest) {
    result.disagreements += count_disagreements(*product, rays, closest);
    return tracing(rays, closest);
  };
  const Times times = take_turns(task, {work([&](const Ray& r) { return quadrics.in_a_list<false>(r); }),
                                        work([&](const Ray& r) { return quadrics.in_a_list<true>(r); }),
                                        work([&](const Ray& r) { return quadrics.in_a_tree<false>(r); }),
                                        work([&](const Ray& r) { return quadrics.in_a_tree<true>(r); })});
  result.add("list", ratio_of(times[0], times[1]));
  result.add("tree", ratio_of(times[2], times[3]));
  return result;
}

// --- rotated objects ---

// The instances of a scene one after another: an object's triangles are tested where the ray meets its box, which is either the
// one around the rotated object in world space, or the object's own, met by the ray in object space.
class RotatedList {
 public:
  explicit RotatedList(const Scene& scene) {
    for (const Object& object : scene.objects) objects_.emplace_back(object.geometry);
    for (const BuildItem& item : instance_items(scene)) {
      const Instance& instance = scene.instances[item.id];
      Bounds own;
      const Geometry& geometry = scene.objects[instance.object].geometry;
      for (const std::uint32_t id : geometry.valid_primitives()) own.extend(geometry.primitive_bounds(id));
      placed_.push_back({item.bounds, own, instance.to_world, instance.object, item.id});
      extent_ = std::max({extent_, largest_coordinate(item.bounds), largest_coordinate(own)});
    }
  }

  template <bool world_box>
  Hit closest(const Ray& ray, std::uint64_t& entered) const {
    Hit best;
    best.t = ray.t_max;
    const ScalarSlab world(ray);
    const TraversalLimit limit(ray, extent_);
    for (const Placed& placed : placed_) {
      if (world_box && world.entry(placed.world, limit(best.t)) == infinity) continue;
      Ray local = to_object_space(placed.to_world, ray);
      local.t_max = best.t;
      if (!world_box && ScalarSlab(local).entry(placed.own, TraversalLimit(local, extent_)(best.t)) == infinity) continue;
      ++entered;
      const Hit hit = objects_[placed.object].closest(local);
      if (!hit || (hit.t == best.t && placed.instance > best.instance)) continue;
      best = hit;
      best.instance = placed.instance;
    }
    return best ? best : Hit{};
  }

 private:
  struct Placed {
    Bounds world, own;
    Transform to_world;
    std::uint32_t object, instance;
  };

  std::vector<BruteForce> objects_;
  std::vector<Placed> placed_;
  float extent_ = 0;
};

MeasureResult measure_rotated(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const RotatedList list(scene);
  const std::vector<Ray> rays = some_rays(scene, task.resolution);
  const auto product = make_structure(scene, "binned-sah");
  MeasureResult result;
  std::uint64_t around = 0, inside = 0, ignored = 0;
  result.disagreements += count_disagreements(*product, rays, [&](const Ray& r) { return list.closest<true>(r, around); });
  result.disagreements += count_disagreements(*product, rays, [&](const Ray& r) { return list.closest<false>(r, inside); });
  const Times times = take_turns(task, {tracing(rays, [&](const Ray& r) { return list.closest<true>(r, ignored); }),
                                        tracing(rays, [&](const Ray& r) { return list.closest<false>(r, ignored); }),
                                        tracing(rays, [&](const Ray& r) { return product->closest(r); })});
  result.add("object_space", ratio_of(times[0], times[1]));
  result.add("entered", inside > 0 ? static_cast<double>(around) / static_cast<double>(inside) : 0);
  result.add("both", ratio_of(times[1], times[2]));
  return result;
}

}  // namespace

std::vector<Measurement> object_measurements() {
  return {{"cylinders",
           "time without a box before each cylinder over that with one",
           {{"list", factor, "no box over box, all cylinders in a list"},
            {"tree", factor, "no box over box, in the leaves of a tree"}},
           measure_cylinders},
          {"rotated",
           "time with a world-space box around each rotated object over that with the ray in object space first",
           {{"object_space", factor, "box around the rotated object over ray in object space"},
            {"entered", factor, "objects entered, box around the rotated object over its own"},
            {"both", factor, "ray in object space over a tree of world boxes above it, as the product has it"}},
           measure_rotated}};
}

}  // namespace etendue
