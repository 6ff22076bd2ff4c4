#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "framework/core/error.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

namespace etendue {
namespace {

// Scenes that are one but for a number: "builtin:mesh?triangles=1k", "builtin:mesh?triangles=10k".
struct Sweep {
  std::string family, parameter;  // the family's name keeps the parameters that do not change
  std::map<double, std::string> scenes;
};

std::optional<double> number_in(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  if (const auto [parsed, error] = std::from_chars(text.data(), end, value); error == std::errc() && parsed == end)
    return value;
  try {
    return static_cast<double>(parse_count(text));
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Offers a scene under each of its parameters: by the name without it and the parameter, at its value.
void offer_scene(const std::string& scene, std::map<std::pair<std::string, std::string>, Sweep>& sweeps) {
  const std::size_t question = scene.find('?');
  if (question == std::string::npos) return;
  std::vector<std::string> pairs;
  std::istringstream stream(scene.substr(question + 1));
  for (std::string pair; std::getline(stream, pair, ',');) pairs.push_back(pair);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t equals = pairs[i].find('=');
    const auto value = equals == std::string::npos ? std::nullopt : number_in(pairs[i].substr(equals + 1));
    if (!value || *value <= 0) continue;
    std::string family = scene.substr(0, question);
    char separator = '?';
    for (std::size_t j = 0; j < pairs.size(); ++j)
      if (j != i) family += std::exchange(separator, ',') + pairs[j];
    const std::string parameter = pairs[i].substr(0, equals);
    Sweep& sweep = sweeps[{family, parameter}];
    sweep.family = family;
    sweep.parameter = parameter;
    sweep.scenes[*value] = scene;
  }
}

std::vector<Sweep> find_sweeps(const ReportData& data) {
  std::map<std::pair<std::string, std::string>, Sweep> sweeps;
  for (const SceneData& scene : data.scenes) offer_scene(scene.name, sweeps);
  std::vector<Sweep> found;
  for (auto& [key, sweep] : sweeps)
    if (sweep.scenes.size() >= 3) found.push_back(std::move(sweep));
  return found;
}

// A figure of a record, with its quartiles; 0: none.
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

Chart sweep_chart(const ReportData& data, const Sweep& sweep, const std::vector<std::string>& names, const std::string& title,
                  Quantity quantity) {
  Chart chart;
  chart.x = {sweep.parameter, Scale::log, std::nullopt};
  chart.y = {title, Scale::log, std::nullopt};
  for (std::size_t i = 0; i < names.size(); ++i) {
    ChartSeries series;
    series.key = fmt::format("s{}", i);
    series.label = names[i];
    series.colour = i % chart_colours;
    series.dash = i / chart_colours % chart_dashes;
    series.marker = (i + i / chart_colours) % chart_markers;
    for (const auto& [value, scene] : sweep.scenes)
      for (const StructureRecord& record : data.log->structures)
        if (record.scene == scene && structure_name(record) == names[i])
          if (const Measured y = quantity(record); y.median > 0) series.points.push_back({value, y.median, y.low, y.high});
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<Figure> structure_sweep_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (const Sweep& sweep : find_sweeps(data)) {
    std::vector<std::string> names, notes;
    for (const StructureRecord& record : data.log->structures) {
      const bool inside = std::any_of(sweep.scenes.begin(), sweep.scenes.end(),
                                      [&](const auto& entry) { return entry.second == record.scene; });
      const std::string name = structure_name(record);
      if (!inside) continue;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      if (record.build_s.median == 0 && !record.note.empty())
        notes.push_back(fmt::format("{}, {}: {}.", name, record.scene, record.note));
    }
    if (names.empty()) continue;
    Figure figure{fmt::format("structures-sweep-{}-{}", slug(sweep.family), slug(sweep.parameter)),
                  sweep.family,
                  fmt::format("cost against {}", sweep.parameter),
                  {},
                  std::move(notes)};
    for (const auto& [title, quantity] : {std::pair<const char*, Quantity>{"diffuse rays [ns per ray]", diffuse_cost},
                                          {"build, one thread [s]", build_time},
                                          {"memory [bytes per triangle]", bytes_per_triangle}}) {
      Chart chart = sweep_chart(data, sweep, names, title, quantity);
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
    const double cost = nanoseconds_per_ray(record.speed(RayKind::diffuse));
    if (cost == 0) continue;
    const std::string name = structure_name(record);
    if (!costs.contains(name)) names.push_back(name);
    if (!fastest.contains(record.scene)) scenes.push_back(record.scene);
    const auto [best, fresh] = fastest.try_emplace(record.scene, cost);
    best->second = std::min(best->second, cost);
    costs[name][record.scene] = cost;
  }
  if (scenes.size() < 2 || names.size() < 2) return {};
  constexpr double off_the_chart = 100;  // times the fastest, in every scene
  std::vector<std::string> notes{"Diffuse rays on one thread, over the fastest structure in the scene."};
  std::vector<std::pair<double, std::string>> rows;  // by the worst scene
  for (const std::string& name : names) {
    double worst = 0, best = infinity;
    for (const auto& [scene, cost] : costs[name]) {
      worst = std::max(worst, cost / fastest[scene]);
      best = std::min(best, cost / fastest[scene]);
    }
    if (best > off_the_chart)
      notes.push_back(fmt::format("Outside the chart: {}, {} times the fastest or more.", name, format_figure(best)));
    else
      rows.emplace_back(worst, name);
  }
  std::stable_sort(rows.begin(), rows.end());
  Chart chart;
  chart.x = {"cost of a ray over the fastest's", Scale::log, std::nullopt};
  for (const auto& [worst, name] : rows) chart.rows.push_back(name);
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    ChartSeries series;
    series.key = fmt::format("scene{}", s);
    series.label = scenes[s];
    series.colour = s % chart_colours;
    series.marker = (s + s / chart_colours) % chart_markers;
    series.draw = ChartSeries::Draw::dots;
    for (std::size_t row = 0; row < rows.size(); ++row)
      if (const auto cost = costs[rows[row].second].find(scenes[s]); cost != costs[rows[row].second].end()) {
        const auto y = static_cast<double>(row);
        series.points.push_back({cost->second / fastest[scenes[s]], y, y, y});
      }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return {"structures-over-scenes", "all scenes", "who suffers where", {std::move(chart)}, std::move(notes)};
}

}  // namespace etendue
