// The charts of a report.
//
//   error over time        log-log, a series for each integrator and structure, bands over seeds; the main chart
//   error over iterations  where structures must coincide: they change only the time
//   front                  every checkpoint of every configuration as (time, error) and what nothing beats
//
// Beyond ten series the error charts split into panels, one an integrator, the others' curves grey behind.
#pragma once

#include "experiments/report/charts/chart_svg.h"
#include "experiments/report/report_data.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct Figure {
  std::string name = {};  // of its file, without the ending
  std::string scene = {}, title = {};
  std::vector<Chart> panels = {};
  std::vector<std::string> notes = {};

  bool empty() const { return panels.empty(); }
};

// `scale` is of the error axis and of time or iterations alike; a signed metric keeps its error axis linear.
Figure error_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Abscissa abscissa, Scale scale);
Figure front_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Scale scale);

// Makes those that are kept as files: every metric, on log axes.
std::vector<Figure> file_figures(const ReportData& data);

std::string to_svg(const Figure& figure);

}  // namespace etendue
