// The charts of a report.
//
//   error over time        log-log, a series for each integrator and structure, bands over seeds; the main chart
//   error over iterations  where structures must coincide: they change only the time
//   front                  every checkpoint of every configuration as (time, error) and what nothing beats
//
// Beyond ten series the error charts that are kept as files split into panels, one an integrator, the others' curves grey
// behind.
#pragma once

#include "experiments/report/charts/chart_svg.h"
#include "experiments/report/report_data.h"

#include <string>
#include <vector>

namespace etendue {

struct Figure {
  std::string name = {};  // of its file, without the ending
  std::string scene = {}, title = {};
  std::vector<Chart> panels = {};
  std::vector<std::string> notes = {};
  Drawing drawing = {};  // in the place of panels

  bool empty() const { return panels.empty() && drawing.svg.empty(); }
};

// All configurations in one plot, or beyond ten in panels, one an integrator.
enum class Layout : std::uint8_t { panels, overlay };

// `scale` is of the error axis and of time or iterations alike; a signed metric keeps its error axis linear.
Figure error_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Abscissa abscissa, Scale scale,
                    Layout layout = Layout::panels);
// A signed metric is drawn by its magnitude.
Figure front_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Scale scale);

// Makes those that are kept as files: every metric, on log axes.
std::vector<Figure> file_figures(const ReportData& data);

std::string to_svg(const Figure& figure);

// Figures as papers take them: a LaTeX file of its own that draws with pgfplots, and its points as a table beside it.
//
// Writes a document of class `standalone`, which reads `data_file`: pdflatex makes one page of it, and with the package
// `standalone` a paper inputs it as it is. Colours, dashes and marks are those of the SVG.
std::string to_pgfplots(const Figure& figure, const std::string& data_file);
// The points of all series: columns "series x y low high", of which the comments name the series.
std::string pgfplots_data(const Figure& figure);

// An empty series in the colour, dash and mark that a configuration has on the whole page.
ChartSeries method_series(const ReportData& data, const Configuration& configuration);

}  // namespace etendue
