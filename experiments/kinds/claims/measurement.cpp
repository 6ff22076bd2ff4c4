#include "experiments/kinds/claims/measurement.h"

#include "experiments/config/method.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/rows.h"
#include "experiments/kinds/structures/accel_rays.h"
#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

Trial::Trial(const MeasureTask& of, const std::vector<Quantity>& wanted)
    : task(of), scene(load_claim_scene(of.scene, of.reading)), quantities_(wanted) {
  for (const Quantity& quantity : wanted)
    for (const std::string& work : {quantity.over, quantity.time})
      if (!work.empty() && !contains(works_, work)) works_.push_back(work);
}

void Trial::race(const std::vector<Contender>& contenders, int repetitions) {
  const Times times = take_turns(mapped(contenders, &Contender::work), repetitions, task.progress);
  for (std::size_t i = 0; i < contenders.size(); ++i) CHECK(times_.emplace(contenders[i].name, times[i]).second);
}

void Trial::scale(const std::string& name, double factor) {
  for (double& seconds : times_.at(name)) seconds *= factor;
}

Measured Trial::ratio(const std::string& name, const std::string& over) const {
  return summarise(ratios(times_.at(name), times_.at(over)));
}

const RayQuery& Trial::make(const std::string& label) {
  const std::string name = label.substr(0, label.find(' '));
  return *structures_.emplace_back(find_ray_structure(name, {}).make(scene, params_of(label.substr(name.size()))));
}

void Trial::race_structures(const TrialRays& rays) {
  race(mapped(works_, [&](const std::string& work) { return Contender{work, tracing_all(make(work), rays)}; }));
}

TrialRays Trial::record_rays(int resolution) const {
  const auto tracer = find_ray_structure("binned-sah", {}).make(scene, params_of("layout=bvh8"));
  RaysByKind recorded = etendue::record_rays(scene, *tracer, resolution);
  TrialRays rays{std::move(recorded[index_of(RayKind::primary)]), std::move(recorded[index_of(RayKind::shadow)])};
  const std::vector<Ray>& diffuse = recorded[index_of(RayKind::diffuse)];
  rays.closest.insert(rays.closest.end(), diffuse.begin(), diffuse.end());
  return rays;
}

MeasureResult Trial::finish() const {
  MeasureResult result{{}, remarks_, disagreements_};
  for (const Quantity& quantity : quantities_) {
    if (const auto counted = counts_.find(quantity.name); counted != counts_.end())
      result.figures.emplace_back(quantity.name, counted->second);
    else if (times_.contains(quantity.time))
      result.figures.emplace_back(quantity.name,
                                  quantity.over.empty() ? time(quantity.time) : ratio(quantity.time, quantity.over));
  }
  return result;
}

MeasureResult Measurement::run(const MeasureTask& task) const {
  Trial trial(task, quantities);
  measure(trial);
  return trial.finish();
}

const Quantity* Measurement::quantity(std::string_view quantity_name) const {
  const auto found = std::ranges::find_if(quantities, [&](const Quantity& q) { return q.name == quantity_name; });
  return found == quantities.end() ? nullptr : &*found;
}

std::span<const Measurement> measurements() {
  static const std::vector<Measurement> all = [] {
    std::vector<Measurement> rows;
    for (const auto& group :
         {builder_measurements(), traversal_measurements(), change_measurements(), space_measurements(), object_measurements(),
          image_measurements(), task_measurements(), sampling_measurements(), content_measurements(), coarse_measurements()})
      rows.insert(rows.end(), group.begin(), group.end());
    return rows;
  }();
  return all;
}

const Measurement& find_measurement(const std::string& name, const Location& where) {
  return find_by_name(measurements(), "measurement", name, where);
}

ParamMap params_of(const std::string& text) {
  ParamMap params;
  for (const std::string& word : words_of(text)) {
    const std::size_t equals = word.find('=');
    params[word.substr(0, equals)] = parse_param_value(word.substr(equals + 1), {});
  }
  return params;
}

std::vector<Ray> every_nth(const std::vector<Ray>& rays, std::size_t count) {
  if (rays.size() <= count) return rays;
  std::vector<Ray> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(rays[i * rays.size() / count]);
  return kept;
}

}  // namespace etendue
