#include "experiments/kinds/stress/structure_hazard.h"

#include "accel/registry.h"
#include "experiments/kinds/structures/accel_check.h"
#include "experiments/kinds/structures/accel_rays.h"

namespace etendue {

namespace {

constexpr int side = 64;  // camera rays across, and down

// Camera rays through jittered places of the film, each followed by a diffuse one from where it hits.
std::vector<Ray> traced_rays(const Scene& scene, const ExactTracer& tracer, const RayQuery& structure, std::uint64_t seed) {
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    Sampler sampler(SamplerKind::independent, seed, Stream::camera, i, 0);
    const vec2 film = vec2(i % side, i / side) + sampler.get_2d();
    const Ray ray = scene.camera.ray(ivec2(side), film, sampler.get_2d());
    rays.push_back(ray);
    if (const Hit hit = structure.closest(ray); hit && tracer.is_right(ray, hit, tracer.closest(ray)))
      rays.push_back(cosine_bounce(scene, ray, hit, sampler));
  }
  return rays;
}

}  // namespace

StructureHazard measure_structure_hazard(const Scene& scene, const Method& structure, std::uint64_t seed) {
  const RayEntry& entry = find_ray_structure(structure.name, structure.where);
  ParamMap params = structure.params;
  if (entry.tree) params.try_emplace("layout", ParamValue{std::string("binary"), {}});
  const std::unique_ptr<RayQuery> query = entry.make(scene, params);
  const std::uint64_t bytes = query->stats().bytes;
  const ExactTracer tracer(scene);
  const std::vector<Ray> traced = traced_rays(scene, tracer, *query, seed), aimed = aimed_rays(scene, 0, side * side);

  TraversalCounters counters;
  for (const Ray& ray : traced) query->closest_counted(ray, counters);
  const auto rays = static_cast<double>(traced.size());
  std::uint64_t primitives = 0;
  for (const Object& object : scene.objects) primitives += object.geometry.valid_primitives().size();
  StructureHazard measured{
      .nodes_per_ray = static_cast<double>(counters.nodes) / rays,
      .tests_per_ray = static_cast<double>(counters.primitives) / rays,
      .bytes = bytes,
      .bytes_per_primitive = static_cast<double>(bytes) / static_cast<double>(std::max<std::uint64_t>(1, primitives))};
  for (const std::vector<Ray>& asked : {traced, aimed})
    measured.wrong_answers += wrong_hits(tracer, *query, asked, exact_hits(tracer, asked));
  return measured;
}

}  // namespace etendue
