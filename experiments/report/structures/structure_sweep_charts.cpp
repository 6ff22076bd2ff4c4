#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "framework/core/error.h"
#include "framework/core/units.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace etendue {
namespace {

// Scenes that are one but for a number ("builtin:mesh?triangles=1k", "builtin:mesh?triangles=10k"), by that number. The
// family's name keeps the parameters that do not change.
struct SweepName {
  std::string family, parameter;
  auto operator<=>(const SweepName&) const = default;
};
using SweepScenes = std::map<double, std::string>;

std::optional<double> number_in(const std::string& text) {
  if (const auto number = parse_number(text)) return number;
  try {
    return static_cast<double>(parse_count(text));
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Every scene belongs to a sweep of each of its parameters that is a number; one of three scenes or more is worth a chart.
std::map<SweepName, SweepScenes> find_sweeps(const ReportData& data) {
  std::map<SweepName, SweepScenes> sweeps;
  for (const SceneData& scene : data.scenes) {
    const std::size_t mark = scene.name.find('?');
    if (mark == std::string::npos) continue;
    const std::vector<std::string> pairs = split(std::string_view(scene.name).substr(mark + 1), ",");
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::size_t equals = pairs[i].find('=');
      const auto value = equals == std::string::npos ? std::nullopt : number_in(pairs[i].substr(equals + 1));
      if (!value || *value <= 0) continue;
      std::vector<std::string> others = pairs;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const std::string family = scene.name.substr(0, mark) + (others.empty() ? "" : "?" + joined(others, ","));
      sweeps[{family, pairs[i].substr(0, equals)}][*value] = scene.name;
    }
  }
  std::erase_if(sweeps, [](const auto& sweep) { return sweep.second.size() < 3; });
  return sweeps;
}

// Gives a figure of a record, with its quartiles; 0: there is none.
using Quantity = Measured (*)(const StructureRecord&);

Measured diffuse_cost(const StructureRecord& r) {
  const Measured& speed = r.speed(RayKind::diffuse);
  if (speed.median <= 0) return {};
  return {1e3 / speed.median, 1e3 / speed.high, 1e3 / speed.low};
}

Measured build_time(const StructureRecord& r) { return r.build_s; }

Measured bytes_per_triangle(const StructureRecord& r) {
  const double bytes = r.triangles > 0 ? static_cast<double>(r.bytes) / static_cast<double>(r.triangles) : 0;
  return {bytes, bytes, bytes};
}

Chart sweep_chart(const ReportData& data, const SweepScenes& scenes, const std::vector<std::string>& names, Quantity quantity) {
  Chart chart;
  for (std::size_t i = 0; i < names.size(); ++i) {
    ChartSeries series{.key = names[i], .label = names[i]};
    for (const auto& [value, scene] : scenes)
      for (const StructureRecord& record : data.log->structures)
        if (record.scene == scene && structure_name(record) == names[i]) {
          style_structure(series, data, record);
          if (const Measured y = quantity(record); y.median > 0) series.points.emplace_back(value, y.median, y.low, y.high);
        }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<Figure> structure_sweep_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (const auto& [sweep, scenes] : find_sweeps(data)) {
    Figure figure{.name = fmt::format("structures-sweep-{}-{}", slug(sweep.family), slug(sweep.parameter)),
                  .scene = sweep.family,
                  .title = fmt::format("cost against {}", sweep.parameter)};
    std::vector<std::string> names;
    for (const StructureRecord& record : data.log->structures) {
      const auto is_its = [&](const auto& entry) { return entry.second == record.scene; };
      if (std::ranges::none_of(scenes, is_its)) continue;
      index_in(names, structure_name(record));
      if (record.build_s.median == 0 && !record.note.empty())
        figure.notes.push_back(fmt::format("{}, {}: {}.", structure_name(record), record.scene, record.note));
    }
    for (const auto& [title, quantity] : {std::pair<const char*, Quantity>{"diffuse rays [ns per ray]", diffuse_cost},
                                          {"build, one thread [s]", build_time},
                                          {"memory [bytes per triangle]", bytes_per_triangle}}) {
      Chart chart = sweep_chart(data, scenes, names, quantity);
      chart.x = {sweep.parameter};
      chart.y = {title};
      if (!chart.series.empty()) figure.panels.push_back(std::move(chart));
    }
    if (!figure.panels.empty()) figures.push_back(std::move(figure));
  }
  return figures;
}

Figure structures_over_scenes_figure(const ReportData& data) {
  std::map<std::string, double> fastest;  // by scene, ns per diffuse ray
  std::vector<std::string> scenes, names;
  std::map<std::string, std::map<std::string, double>> costs;  // by structure and scene
  for (const StructureRecord& record : data.log->structures) {
    const double cost = ray_cost(record);
    if (cost == 0) continue;
    index_in(names, structure_name(record));
    index_in(scenes, record.scene);
    costs[structure_name(record)][record.scene] = cost;
    double& best = fastest.try_emplace(record.scene, cost).first->second;
    best = std::min(best, cost);
  }
  if (scenes.size() < 2 || names.size() < 2) return {};
  for (auto& [name, by_scene] : costs)
    for (auto& [scene, cost] : by_scene) cost /= fastest[scene];
  constexpr double off_the_chart = 100;  // times the fastest, in every scene
  std::vector<std::string> notes{"Diffuse rays on one thread, over the fastest structure in the scene."};
  std::vector<std::pair<double, std::string>> rows;  // by the worst scene
  for (const std::string& name : names) {
    const auto less = [](const auto& a, const auto& b) { return a.second < b.second; };
    const auto [best, worst] = std::ranges::minmax_element(costs[name], less);
    if (best->second > off_the_chart)
      notes.push_back(fmt::format("Outside the chart: {}, {} times the fastest or more.", name, format_figure(best->second)));
    else
      rows.emplace_back(worst->second, name);
  }
  std::ranges::stable_sort(rows);
  Chart chart{.x = {"cost of a ray over the fastest's"}};
  for (const auto& [worst, name] : rows) chart.rows.push_back(name);
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const auto cost = [&](std::size_t row) { return find_value(costs[chart.rows[row]], scenes[s]).value_or(0); };
    ChartSeries series = marks_in_rows(scenes[s], s, rows.size(), cost);
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return {"structures-over-scenes", "all scenes", "who suffers where", {std::move(chart)}, std::move(notes)};
}

}  // namespace etendue
