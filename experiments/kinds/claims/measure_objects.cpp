// Tests of single objects: claims about boxes before cylinders, and about rotated objects.
#include "accel/scene/two_level.h"
#include "accel/spatial/brute_force.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/naive_loop.h"

namespace etendue {

namespace {

// A list takes each ray past every object: few will do.
std::vector<Ray> some_rays(const Trial& t) { return every_nth(t.record_rays().closest, 16384); }

// --- a box before each quadric ---

// Every quadric of a scene (its triangles are left out), with its box tested first or not.
class Quadrics {
 public:
  explicit Quadrics(const Geometry& all) : geometry_{{}, {}, all.quadrics} {
    for (std::uint32_t id = 0; id < geometry_.primitive_count(); ++id) items_.push_back({geometry_.primitive_bounds(id), id});
    if (items_.empty()) throw Error("no quadric in the scene; expected cylinders or spheres");
    tree_.emplace(geometry_, find_ray_structure("binned-sah", {}).builder({})(items_));
  }

  const Geometry& geometry() const { return geometry_; }

  // Quadrics are tested one after another.
  template <bool boxed>
  Hit in_a_list(const Ray& ray) const {
    const ScalarSlab slab(ray);
    return closest_of(ray, tree_->extent(), [&](Hit& hit, const TraversalLimit& limit) {
      for (const BuildItem& item : items_)
        if (is_met<boxed>(slab, item.id, limit, hit.t)) intersect_primitive(geometry_, item.id, ray, {}, hit);
    });
  }
  // Quadrics are tested in the leaves of a tree.
  template <bool boxed>
  Hit in_a_tree(const Ray& ray) const {
    const ScalarSlab slab(ray);
    return tree_->closest<TraversalOptions{}, ScalarSlab>(
        ray,
        [&](std::uint32_t id, const TraversalLimit& limit, float t_best) { return is_met<boxed>(slab, id, limit, t_best); });
  }

 private:
  template <bool boxed>
  bool is_met(const ScalarSlab& slab, std::uint32_t id, const TraversalLimit& limit, float t_best) const {
    return !boxed || slab.entry(items_[id].bounds, limit(t_best)) < infinity;
  }

  Geometry geometry_;
  BuildItems items_;  // by id
  std::optional<NaiveTree> tree_;
};

void measure_cylinders(Trial& t) {
  const Quadrics quadrics(t.scene.objects[0].geometry);
  const std::vector<Ray> rays = some_rays(t);
  Scene alone;
  alone.objects[0].geometry = quadrics.geometry();
  const auto product = find_ray_structure("binned-sah", {}).make(alone, {});
  const auto entry = [&](const char* name, const auto& closest) {
    t.hold_to(*product, rays, closest);
    return Contender{name, tracing(rays, closest)};
  };
  t.race({entry("list", [&](const Ray& r) { return quadrics.in_a_list<false>(r); }),
          entry("list boxed", [&](const Ray& r) { return quadrics.in_a_list<true>(r); }),
          entry("tree", [&](const Ray& r) { return quadrics.in_a_tree<false>(r); }),
          entry("tree boxed", [&](const Ray& r) { return quadrics.in_a_tree<true>(r); })});
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

void measure_rotated(Trial& t) {
  const RotatedList list(t.scene);
  const std::vector<Ray> rays = some_rays(t);
  const RayQuery& product = t.make("binned-sah");
  std::uint64_t around = 0, inside = 0, ignored = 0;
  t.hold_to(product, rays, [&](const Ray& r) { return list.closest<true>(r, around); });
  t.hold_to(product, rays, [&](const Ray& r) { return list.closest<false>(r, inside); });
  t.race({{"world box", tracing(rays, [&](const Ray& r) { return list.closest<true>(r, ignored); })},
          {"own box", tracing(rays, [&](const Ray& r) { return list.closest<false>(r, ignored); })},
          {"product", tracing(rays, [&](const Ray& r) { return product.closest(r); })}});
  t.count("entered", inside > 0 ? static_cast<double>(around) / static_cast<double>(inside) : 0);
}

}  // namespace

std::vector<Measurement> object_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {{"cylinders",
           "time without a box before each cylinder over that with one",
           {{"list", factor, "no box over box, all cylinders in a list", "list", "list boxed"},
            {"tree", factor, "no box over box, in the leaves of a tree", "tree", "tree boxed"}},
           measure_cylinders},
          {"rotated",
           "time with a world-space box around each rotated object over that with the ray in object space first",
           {{"object_space", factor, "box around the rotated object over ray in object space", "world box", "own box"},
            {"entered", factor, "objects entered, box around the rotated object over its own"},
            {"both", factor, "ray in object space over a tree of world boxes above it, as the product has it", "own box",
             "product"}},
           measure_rotated}};
}

}  // namespace etendue
