#include "experiments/kinds/claims/measure_tools.h"

#include "experiments/kinds/structures/accel_rays.h"

namespace etendue {

ClaimRays record_claim_rays(const Scene& scene, int resolution) {
  const std::unique_ptr<RayQuery> tracer = make_structure(scene, "binned-sah", text_param("layout", "bvh8"));
  RaysByKind recorded = record_rays(scene, *tracer, resolution);
  ClaimRays rays{std::move(recorded[index_of(RayKind::primary)]), std::move(recorded[index_of(RayKind::shadow)])};
  const std::vector<Ray>& diffuse = recorded[index_of(RayKind::diffuse)];
  rays.closest.insert(rays.closest.end(), diffuse.begin(), diffuse.end());
  return rays;
}

std::vector<Ray> every_nth(const std::vector<Ray>& rays, std::size_t count) {
  if (rays.size() <= count) return rays;
  std::vector<Ray> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(rays[i * rays.size() / count]);
  return kept;
}

std::unique_ptr<RayQuery> make_structure(const Scene& scene, const std::string& name, const ParamMap& params) {
  return find_ray_structure(name, {}).make(scene, params);
}

ParamMap text_param(const char* key, const std::string& value) { return {{key, {value, {}}}}; }
ParamMap whole_param(const char* key, std::int64_t value) { return {{key, {value, {}}}}; }

Times take_turns(const MeasureTask& task, const std::vector<std::function<void()>>& works) {
  Times times(works.size());
  for (const auto& work : works) work();
  for (int repetition = 0; repetition < task.repetitions; ++repetition) {
    for (std::size_t i = 0; i < works.size(); ++i) {
      const std::size_t turn = (i + static_cast<std::size_t>(repetition)) % works.size();
      times[turn].push_back(seconds_of(works[turn]));
    }
    task.progress((repetition + 1.0) / task.repetitions);
  }
  return times;
}

Measured ratio_of(const std::vector<double>& a, const std::vector<double>& b) { return summarise(ratios(a, b)); }

}  // namespace etendue
