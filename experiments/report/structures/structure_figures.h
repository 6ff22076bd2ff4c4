// The charts of ray structures.
//
//   building against tracing  what a structure costs once and for each ray, and what nothing beats in both
//   break-even                total time against the number of rays: the structure to pick for N rays
//   cost per ray              each kind of ray
//   sweeps                    scenes that differ in one parameter (builtin:mesh?triangles=…): cost against it
//   over scenes               each structure against the scene's fastest: which ones suffer where
#pragma once

#include "experiments/report/charts.h"

namespace etendue {

// "binned-sah bvh16".
std::string structure_name(const StructureRecord& record);
double nanoseconds_per_ray(const Measured& mrays_per_s);  // 0 where not measured

Figure structures_figure(const ReportData& data, const SceneData& scene);
Figure break_even_figure(const ReportData& data, const SceneData& scene);
Figure ray_cost_figure(const ReportData& data, const SceneData& scene);
std::vector<Figure> structure_sweep_figures(const ReportData& data);
Figure structures_over_scenes_figure(const ReportData& data);

// The structure of least total cost (one build and `rays` traced rays) from a number of rays on; ascending, the first from 0.
// The structure to pick from so many rays on; where two are equal, the one that traces faster.
struct Choice {
  const StructureRecord* record = nullptr;
  double from_rays = 0;
};
std::vector<Choice> cheapest_choices(const std::vector<const StructureRecord*>& records);

}  // namespace etendue
