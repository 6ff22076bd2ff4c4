// How charts of ray structures tell them apart.
#include "experiments/report/charts/chart_plot.h"
#include "experiments/report/structures/structure_figures.h"
#include "tests/places.h"
#include "tests/unit/report_helpers.h"

#include <cstdio>
#include <map>
#include <set>
#include <tuple>

namespace etendue {
namespace {

using namespace report_test;

// A click on a legend switches all series of a key, on the whole page.
TEST(StructureCharts, KeysNameTheSameStructuresInAllScenesAndSweeps) {
  RunLog log;
  for (const char* count : {"1e3", "1e4", "1e5"})
    log.structures.push_back(structure(std::string("mesh?triangles=") + count, "sah", "bvh8", 2, 0.1));
  for (const char* size : {"1", "2", "3"})
    log.structures.push_back(structure(std::string("hall?size=") + size, "lbvh", "binary", 1, 0.01));
  log.structures.push_back(structure("mesh?triangles=1e3", "lbvh", "binary", 1, 0.01));
  log.structures.push_back(structure("hall?size=1", "grid", "-", 0.9, 0.001));
  std::map<std::string, std::string> names;  // by key
  for (const FigureGroup& group : structures_report(arrange(log)).figures)
    for (const Figure& figure : group.figures)
      for (const Chart& chart : figure.panels)
        for (const ChartSeries& series : chart.series)
          if (series.draw == ChartSeries::Draw::line) {
            const std::string name = series.label.substr(0, series.label.find(" from "));
            EXPECT_EQ(names.try_emplace(series.key, name).first->second, name) << figure.name;
          }
  EXPECT_EQ(names.size(), 3u);
}

// These committed logs have more structures than colours.
std::vector<Figure> figures_of_many_structures() {
  std::vector<Figure> figures;
  for (const char* name : {"structures", "meshes"}) {
    const RunLog log = read_log(project_folder + std::string("results/") + name + "/runs.jsonl");
    for (const FigureGroup& group : structures_report(arrange(log)).figures)
      figures.insert(figures.end(), group.figures.begin(), group.figures.end());
  }
  return figures;
}

TEST(StructureCharts, NoTwoStructuresLookAlike) {
  for (const Figure& figure : figures_of_many_structures())
    for (const Chart& chart : figure.panels) {
      std::set<std::tuple<std::size_t, std::size_t, std::size_t>> looks;
      for (const ChartSeries& series : chart.series)
        if (series.has_marks()) {
          const std::size_t dash = series.draw == ChartSeries::Draw::line ? series.dash : 0;
          EXPECT_TRUE(looks.insert({series.colour, series.marker, dash}).second) << figure.name << ": " << series.label;
        }
    }
}

TEST(StructureCharts, LabelsAreNearestToTheirMarksOrHaveLeaders) {
  std::size_t count = 0;
  for (const Figure& figure : figures_of_many_structures()) {
    const Chart& chart = figure.panels.at(0);
    const Plot plot(chart, {0, 0, 720, 440}, false);
    const std::string svg = plot.svg();
    for (const ChartLabel& label : chart.labels) {
      const std::size_t end = svg.find(" class=\"label\">" + label.text + "<");
      if (end == std::string::npos) continue;
      ++count;
      const std::size_t begin = svg.rfind("<text x=", end);
      if (svg.compare(svg.rfind('<', begin - 1), 20, "<path class=\"leader\"") == 0) continue;
      double x = 0, y = 0;
      ASSERT_EQ(std::sscanf(svg.c_str() + begin, "<text x=\"%lf\" y=\"%lf\"", &x, &y), 2);
      const PixelBox box{x, y + 3.5 - 14, text_width(label.text, 12), 14};
      for (const ChartSeries& series : chart.series) {
        if (!series.has_marks() || series.key == label.text) continue;
        for (const ChartPoint& point : series.points)
          EXPECT_GE(box.distance(plot.place(point.x, point.y)) + 0.2, box.distance(plot.place(label.x, label.y)))
              << figure.name << ": " << label.text << " is nearer to " << series.label;
      }
    }
  }
  EXPECT_GT(count, 40u);
}

}  // namespace
}  // namespace etendue
