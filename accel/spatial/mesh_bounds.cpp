#include "accel/spatial/mesh_bounds.h"

#include "accel/plain_entry.h"

namespace etendue {

static_assert(RayStructure<MeshBounds>);

MeshBounds::MeshBounds(const Object& object) : leaves_(object.geometry) {
  const Geometry& geometry = object.geometry;
  std::vector<double> weights;  // by mesh: area times primitives
  std::uint32_t end = 0;
  const auto add = [&](std::uint32_t first, std::uint32_t stop) {
    std::vector<std::uint32_t> ids;
    Bounds bounds;
    for (std::uint32_t id = first; id < stop; ++id) {
      if (!geometry.is_valid(id)) continue;
      ids.push_back(id);
      bounds.extend(geometry.primitive_bounds(id));
    }
    if (ids.empty()) return;
    bounds_.extend(bounds);
    meshes_.push_back({bounds, leaves_.add(ids)});
    weights.push_back(static_cast<double>(bounds.half_area()) * static_cast<double>(ids.size()));
  };
  for (const Shape& shape : object.shapes) {
    add(shape.first_primitive, shape.first_primitive + shape.primitive_count);
    end = std::max(end, shape.first_primitive + shape.primitive_count);
  }
  add(end, geometry.primitive_count());
  sah_cost_ = static_cast<double>(meshes_.size());
  for (const double weight : weights) sah_cost_ += weight / bounds_.half_area();
  if (!std::isfinite(sah_cost_)) sah_cost_ = 0;  // areas beyond the range of float, or none
}

RayStructureStats MeshBounds::stats() const {
  return {meshes_.size() * sizeof(Mesh) + leaves_.bytes(), meshes_.size(), meshes_.empty() ? 0u : 1u, leaves_.references(),
          sah_cost_};
}

RayEntry bounds_entry() {
  RayEntry entry = plain_entry<NoParams>(
      "bounds", "a box around each mesh, and every primitive of those met",
      [](const NoParams&) { return [](const Object& object) { return MeshBounds(object); }; },
      [](const Geometry& geometry, const NoParams&) { return brute_need(geometry); }, leaf_of_instances);
  // Each mesh has a box, and a pack that it may fill in part.
  entry.need = [triangles = entry.need](const Scene& scene, const ParamMap& params) {
    MemoryNeed need = triangles(scene, params);
    std::uint64_t boxes = 0;
    for (const Object& object : scene.objects)
      boxes += (object.shapes.size() + 1) * (sizeof(Bounds) + sizeof(Leaves::Run) + sizeof(Leaves::Pack));
    need.kept += boxes;
    need.peak += 3 * boxes;
    return need;
  };
  return entry;
}

}  // namespace etendue
