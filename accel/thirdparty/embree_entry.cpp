// The registry's row of Embree; where Embree was not found, the row says so.
#include "accel/plain_entry.h"
#include "accel/thirdparty/embree.h"
#include "framework/core/error.h"

namespace etendue {

RayEntry embree_entry() {
  RayEntry entry{
      .name = "embree", .summary = "Intel's Embree 3, as a baseline", .params = list_params<WithMemory<EmbreeParams>>()};
#ifdef ETENDUE_HAS_EMBREE
  entry.build = [](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    return behind_interface(Embree(scene, read_watched<EmbreeParams>(map, "embree", watch)));
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

}  // namespace etendue
