#include "accel/spatial/brute_force.h"

#include "accel/plain_entry.h"
#include "accel/spatial/brute_in_place.h"

namespace etendue {

static_assert(RayStructure<BruteForce>);

namespace {

struct BruteParams {
  bool in_place = false;
};

template <class Visitor>
void describe(Visitor& v, BruteParams& params) {
  v.flag("in_place", params.in_place, "read primitives where the scene has them: no memory, but slower");
}

}  // namespace

BruteForce::BruteForce(const Geometry& geometry) : leaves_(geometry), all_(leaves_.add(geometry.valid_primitives())) {}

RayStructureStats BruteForce::stats() const {
  return {leaves_.bytes(), 0, 0, leaves_.references(), static_cast<double>(leaves_.references())};
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

}  // namespace etendue
