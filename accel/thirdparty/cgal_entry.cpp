// The registry's row of CGAL; where CGAL was not found, the row says so, and so does the edge collapse.
#include "accel/plain_entry.h"
#include "accel/thirdparty/cgal.h"
#include "accel/thirdparty/collapse.h"
#include "framework/core/error.h"

namespace etendue {

RayEntry cgal_entry() {
  const char* const name = "cgal";
  const char* const summary = "CGAL's AABB tree (GPL-3), in double precision, as a baseline";
  const auto need = [](const Geometry& geometry, const NoParams&) { return cgal_need(geometry); };
#ifdef ETENDUE_HAS_CGAL
  return plain_entry<NoParams>(
      name, summary, [](const NoParams&) { return [](const Geometry& geometry) { return Cgal(geometry); }; }, need,
      sah_over_instances);
#else
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<NoParams> >(), .available = false};
  entry.build = [](const Scene&, const ParamMap&, MemoryWatch*) -> std::unique_ptr<RayQuery> {
    throw Error("structure 'cgal' is not available: this build was made without CGAL");
  };
  entry.need = [need](const Scene& scene, const ParamMap&) {
    return scene_need(scene, [&](const Geometry& geometry) { return need(geometry, {}); });
  };
  return entry;
#endif
}

#ifndef ETENDUE_HAS_CGAL
std::vector<CoarseMesh> collapse_edges(std::span<const vec3>, std::span<const uvec3>, std::span<const double>) {
  throw Error("meshes cannot be made coarser: this build was made without CGAL");
}
#endif

}  // namespace etendue
