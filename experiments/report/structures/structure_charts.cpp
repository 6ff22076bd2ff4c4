#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {
namespace {

// A scene's structures without those that cost many times what most do (brute force): they would press all others into a
// corner. Notes say what they cost.
std::vector<const StructureRecord*> comparable_structures(const ReportData& data, const SceneData& scene,
                                                          std::vector<std::string>& notes) {
  std::vector<const StructureRecord*> records;
  std::vector<double> costs;
  for (const StructureRecord& record : data.log->structures)
    if (record.scene == scene.name && ray_cost(record) > 0) {
      records.push_back(&record);
      costs.push_back(ray_cost(record));
    }
  if (records.size() < 3) return records;
  const double limit = 20 * median(costs);
  std::erase_if(records, [&](const StructureRecord* record) {
    const bool outside = ray_cost(*record) > limit;
    if (outside)
      notes.push_back(fmt::format("Outside the chart: {}, built in {}, {} a diffuse ray.", structure_name(*record),
                                  format_seconds(record->build_s.median), format_seconds(ray_cost(*record) * 1e-9)));
    return outside;
  });
  return records;
}

std::vector<std::string> layouts_of(const ReportData& data) {
  std::vector<std::string> layouts;
  for (const StructureRecord& record : data.log->structures) index_in(layouts, record.layout);
  return layouts;
}

}  // namespace

std::string structure_name(const StructureRecord& record) {
  return record.layout.empty() || record.layout == "-" ? record.structure : record.structure + " " + record.layout;
}

void style_structure(ChartSeries& series, const ReportData& data, const StructureRecord& record) {
  std::vector<std::string> names, layouts, known;
  std::set<std::pair<std::size_t, std::size_t>> taken;  // colours with marks
  for (const StructureRecord& other : data.log->structures) {
    const std::size_t name = index_in(names, other.structure), layout = index_in(layouts, other.layout), count = known.size();
    if (index_in(known, structure_name(other)) < count) continue;
    const std::size_t colour = name % chart_colours;
    std::size_t marker = layout % chart_markers;
    for (std::size_t next = chart_markers; taken.contains({colour, marker}) && next > 0;) marker = --next;
    taken.insert({colour, marker});
    if (structure_name(other) != structure_name(record)) continue;
    series.colour = colour;
    series.dash = (layout + name / chart_colours) % chart_dashes;
    series.marker = marker;
    return;
  }
}

double ray_cost(const StructureRecord& record, RayKind kind) {
  const double mrays_per_s = record.speed(kind).median;
  return mrays_per_s > 0 ? 1e3 / mrays_per_s : 0;
}

Figure structures_figure(const ReportData& data, const SceneData& scene) {
  using Draw = ChartSeries::Draw;
  std::vector<std::string> notes;
  const auto records = comparable_structures(data, scene, notes);
  if (records.size() < 2) return {};
  Chart chart{.x = {"build time [s]"}, .y = {"diffuse rays, one thread [ns per ray]"}};
  std::vector<dvec2> positions;
  std::vector<std::string> layouts = layouts_of(data);
  bool other_shapes = false;
  std::map<std::string, ChartSeries> links;  // a grey line through the layouts of one structure
  for (const StructureRecord* record : records) {
    const dvec2 at = positions.emplace_back(std::max(record->build_s.median, 1e-6), ray_cost(*record));
    ChartSeries& mark = chart.series.emplace_back();
    mark = {.key = record->structure,
            .label = record->structure,
            .detail = record->layout == "-" ? "" : record->layout,
            .draw = Draw::dots,
            .points = {{at.x, at.y}}};
    style_structure(mark, data, *record);
    other_shapes = other_shapes || mark.marker != index_in(layouts, record->layout) % chart_markers;
    links[record->structure].points.emplace_back(at.x, at.y);
  }
  for (auto& [name, link] : links) {
    chart.labels.push_back({link.points.back().x, link.points.back().y, name});
    link.draw = Draw::context;
    if (link.points.size() > 1) chart.series.push_back(std::move(link));
  }
  ChartSeries front{.key = "front", .label = "front: nothing is both built and traced faster", .draw = Draw::stairs};
  for (const std::size_t i : pareto_front(positions)) front.points.emplace_back(positions[i].x, positions[i].y);
  chart.series.insert(chart.series.begin(), std::move(front));  // below the marks
  constexpr const char* shapes[chart_markers] = {"circles",    "squares", "triangles",  "diamonds", "triangles pointing down",
                                                 "plus signs", "crosses", "hourglasses"};
  if (layouts.size() > 1) {
    const auto shape = [&](std::size_t i) {
      return fmt::format("{} {}", shapes[i % chart_markers], layouts[i] == "-" ? "(no choice)" : layouts[i]);
    };
    notes.push_back(fmt::format("Layouts: {}; a grey line joins those of one structure.{}",
                                joined(std::views::iota(std::size_t{0}, layouts.size()), ", ", shape),
                                other_shapes ? " Other shapes tell apart what has one colour and layout." : ""));
  }
  return {"structures-" + scene.file_stem, scene.name, "building against tracing", {std::move(chart)}, notes};
}

Figure ray_cost_figure(const ReportData& data, const SceneData& scene) {
  std::vector<std::string> notes;
  auto records = comparable_structures(data, scene, notes);
  if (records.empty()) return {};
  std::ranges::stable_sort(records, [](const auto* a, const auto* b) { return ray_cost(*a) < ray_cost(*b); });
  Chart chart{.x = {"cost, one thread [ns per ray]"}};
  for (const StructureRecord* record : records) chart.rows.push_back(structure_name(*record));
  for (const RayKind kind : ray_kinds) {
    const auto cost = [&](std::size_t row) { return ray_cost(*records[row], kind); };
    ChartSeries series = marks_in_rows(fmt::format("{} rays", ray_kind_name(kind)), index_of(kind), records.size(), cost);
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return {"ray-cost-" + scene.file_stem, scene.name, "cost per ray", {std::move(chart)}, notes};
}

KindReport structures_report(const ReportData& data) {
  KindReport report{.id = "structures", .heading = "Ray structures"};
  std::set<std::string> names, scenes;
  for (const StructureRecord& record : data.log->structures) {
    names.insert(structure_name(record));
    scenes.insert(record.scene);
  }
  if (names.empty()) return report;
  report.fact = counted(names.size(), "ray structure") + " in " + counted(scenes.size(), "scene");
  const auto add = [&](const std::string& heading, std::vector<Figure> figures) {
    std::erase_if(figures, [](const Figure& figure) { return figure.empty(); });
    if (!figures.empty()) report.figures.push_back({heading, std::move(figures)});
  };
  for (const SceneData& scene : data.scenes)
    add(scene.name, {structures_figure(data, scene), break_even_figure(data, scene), ray_cost_figure(data, scene)});
  for (const Figure& figure : structure_sweep_figures(data)) add(figure.scene + ": " + figure.title, {figure});
  add("Over all scenes", {structures_over_scenes_figure(data)});
  return report;
}

}  // namespace etendue
