// report.html: one page that needs nothing beyond itself.
#pragma once

#include "experiments/report/charts/charts.h"
#include "experiments/report/kind_report.h"
#include "experiments/report/page/images.h"
#include "experiments/report/report_data.h"
#include "experiments/report/table_format.h"

#include <string>
#include <utility>
#include <vector>

namespace etendue {

inline const std::string nameless_experiment = "EXPERIMENT.toml";  // whose file cannot be named

struct PageContent {
  std::vector<KindReport> parts;  // each a section, beside the scenes'
  std::vector<Table> tables;      // the parts' among them
  std::vector<SceneImages> images;
  std::vector<std::string> directories;                          // that the report was made of, as the reader types them
  std::vector<std::pair<std::string, std::string>> experiments;  // files that asked the question: name, text
  std::string answer;                                            // to the experiment's question, in one sentence
  bool has_csv = false;                                          // tables lie beside the page as tables/NAME.csv
  std::size_t chart_budget_bytes = 7 << 20;                      // beyond it, charts of lesser use are left to charts/
};

std::string report_page(const ReportData& data, const PageContent& content);

// A part of the page with a heading that its contents link to; the body is HTML.
struct Section {
  std::string id, heading, body;

  std::string text() const;
  std::string link() const;
};

// Which variants of the charts the page can afford.
struct Variants {
  std::vector<std::string> metrics;
  std::vector<Scale> scales{Scale::log, Scale::linear};
  std::string note;
};
Variants affordable(const ReportData& data, std::size_t budget_bytes);

// The title, the panels and the notes of a figure; and the buttons that switch its series, where there are several.
std::string stage_html(const Figure& figure);
std::string legend_html(const Figure& figure);

// The error at equal time, charts and the viewer.
Section scene_section(const ReportData& data, const SceneData& scene, const Variants& variants,
                      const std::vector<SceneImages>& images);

// All scenes' thumbnails, each a link to its image in the viewer.
std::string gallery_html(const ReportData& data, const std::vector<SceneImages>& scenes);
// The data that the viewers read.
std::string images_json(const std::vector<SceneImages>& scenes);

}  // namespace etendue
