// The charts of ray structures.
//
//   building against tracing  what a structure costs once and for each ray, and what nothing beats in both
//   break-even                total time against the number of rays: the structure to pick for N rays
//   cost per ray              each kind of ray
//   sweeps                    scenes that differ in one parameter (builtin:mesh?triangles=…): cost against it
//   over scenes               each structure against the scene's fastest: which ones suffer where
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// Names a structure with its layout: "binned-sah bvh16".
std::string structure_name(const StructureRecord& record);
// Colour says the structure, mark and dash its layout: the same in every chart of a log. Colours come again from the ninth
// structure on, and a mark that one of that colour has already gives way to one that none has.
void style_structure(ChartSeries& series, const ReportData& data, const StructureRecord& record);
// The cost of a ray, in nanoseconds; 0 where not measured.
double ray_cost(const StructureRecord& record, RayKind kind = RayKind::diffuse);

// A mark in each row of a chart, at cost(row), where that is positive: the `index`-th series of such.
template <class Cost>
ChartSeries marks_in_rows(const std::string& label, std::size_t index, std::size_t rows, const Cost& cost) {
  ChartSeries series{.key = label, .label = label, .draw = ChartSeries::Draw::dots};
  series.style(index);
  for (std::size_t row = 0; row < rows; ++row)
    if (const double x = cost(row); x > 0) series.points.emplace_back(x, static_cast<double>(row));
  return series;
}

KindReport structures_report(const ReportData& data);

Figure structures_figure(const ReportData& data, const SceneData& scene);
Figure break_even_figure(const ReportData& data, const SceneData& scene);
Figure ray_cost_figure(const ReportData& data, const SceneData& scene);
std::vector<Figure> structure_sweep_figures(const ReportData& data);
Figure structures_over_scenes_figure(const ReportData& data);

// The structure of least total cost (one build, and the rays traced) from a number of rays on; ascending, the first from 0.
// Where two are equal, the one that traces faster.
struct Choice {
  const StructureRecord* record = nullptr;
  double from_rays = 0;
};
std::vector<Choice> cheapest_choices(const std::vector<const StructureRecord*>& records);

}  // namespace etendue
