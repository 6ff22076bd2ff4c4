#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace etendue {
namespace {

std::size_t index_in(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

// A scene's structures without those that cost many times what most do (brute force): they would press all others into a
// corner. Notes say what they cost.
std::vector<const StructureRecord*> comparable_structures(const ReportData& data, const SceneData& scene,
                                                          std::vector<std::string>& notes) {
  std::vector<const StructureRecord*> records;
  std::vector<double> costs;
  for (const StructureRecord& record : data.log->structures)
    if (record.scene == scene.name && record.speed(RayKind::diffuse).median > 0) {
      records.push_back(&record);
      costs.push_back(nanoseconds_per_ray(record.speed(RayKind::diffuse)));
    }
  if (records.size() < 3) return records;
  const double limit = 20 * median(costs);
  std::erase_if(records, [&](const StructureRecord* record) {
    const double cost = nanoseconds_per_ray(record->speed(RayKind::diffuse));
    if (cost > limit)
      notes.push_back(fmt::format("Outside the chart: {}, built in {}, {} a diffuse ray.", structure_name(*record),
                                  format_seconds(record->build_s.median), format_seconds(cost * 1e-9)));
    return cost > limit;
  });
  return records;
}

}  // namespace

std::string structure_name(const StructureRecord& record) {
  return record.layout.empty() || record.layout == "-" ? record.structure : record.structure + " " + record.layout;
}

double nanoseconds_per_ray(const Measured& mrays_per_s) { return mrays_per_s.median > 0 ? 1e3 / mrays_per_s.median : 0; }

Figure structures_figure(const ReportData& data, const SceneData& scene) {
  std::vector<std::string> notes;
  const auto records = comparable_structures(data, scene, notes);
  if (records.size() < 2) return {};
  Chart chart;
  chart.x = {"build time [s]", Scale::log, std::nullopt};
  chart.y = {"diffuse rays, one thread [ns per ray]", Scale::log, std::nullopt};
  std::vector<std::string> names, layouts;
  std::vector<dvec2> positions;
  std::map<std::string, ChartSeries> links;  // a grey line through the layouts of one structure
  std::map<std::string, ChartLabel> labels;
  for (const StructureRecord* record : records) {
    const std::size_t index = index_in(names, record->structure);
    ChartSeries series;
    series.key = series.label = record->structure;
    series.detail = record->layout == "-" ? "" : record->layout;
    series.colour = index % chart_colours;
    series.marker = index_in(layouts, record->layout) % chart_markers;
    series.draw = ChartSeries::Draw::dots;
    const dvec2 at(std::max(record->build_s.median, 1e-6), nanoseconds_per_ray(record->speed(RayKind::diffuse)));
    series.points = {{at.x, at.y, at.y, at.y}};
    positions.push_back(at);
    chart.series.push_back(std::move(series));
    links[record->structure].points.push_back({at.x, at.y, at.y, at.y});
    labels[record->structure] = {at.x, at.y, record->structure};
  }
  for (auto& [name, link] : links) {
    link.draw = ChartSeries::Draw::context;
    if (link.points.size() > 1) chart.series.push_back(std::move(link));
  }
  for (const auto& [name, label] : labels) chart.labels.push_back(label);
  ChartSeries front;
  front.key = "front";
  front.label = "front: nothing is both built and traced faster";
  front.draw = ChartSeries::Draw::stairs;
  for (const std::size_t i : pareto_front(positions))
    front.points.push_back({positions[i].x, positions[i].y, positions[i].y, positions[i].y});
  chart.series.insert(chart.series.begin(), std::move(front));  // below the marks
  constexpr const char* shapes[chart_markers] = {"circles",    "squares", "triangles",  "diamonds", "triangles pointing down",
                                                 "plus signs", "crosses", "hourglasses"};
  if (layouts.size() > 1) {
    std::string text = "Layouts:";
    for (std::size_t i = 0; i < layouts.size(); ++i)
      text +=
          fmt::format("{} {} {}", i > 0 ? "," : "", shapes[i % chart_markers], layouts[i] == "-" ? "(no choice)" : layouts[i]);
    notes.push_back(text + "; a grey line joins those of one structure.");
  }
  return {"structures-" + scene.file_stem, scene.name, "building against tracing", {std::move(chart)}, notes};
}

Figure ray_cost_figure(const ReportData& data, const SceneData& scene) {
  std::vector<std::string> notes;
  auto records = comparable_structures(data, scene, notes);
  if (records.empty()) return {};
  std::stable_sort(records.begin(), records.end(), [](const auto* a, const auto* b) {
    return a->speed(RayKind::diffuse).median > b->speed(RayKind::diffuse).median;
  });
  Chart chart;
  chart.x = {"cost, one thread [ns per ray]", Scale::log, std::nullopt};
  for (const RayKind kind : ray_kinds) {
    ChartSeries series;
    series.key = fmt::format("k{}", index_of(kind));
    series.label = std::string(ray_kind_name(kind)) + " rays";
    series.colour = series.marker = index_of(kind);
    series.draw = ChartSeries::Draw::dots;
    for (std::size_t row = 0; row < records.size(); ++row)
      if (const double cost = nanoseconds_per_ray(records[row]->speed(kind)); cost > 0) {
        const auto y = static_cast<double>(row);
        series.points.push_back({cost, y, y, y});
      }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  for (const StructureRecord* record : records) chart.rows.push_back(structure_name(*record));
  return {"ray-cost-" + scene.file_stem, scene.name, "cost per ray", {std::move(chart)}, notes};
}

}  // namespace etendue
