// report.html: one page that needs nothing beyond itself.
#pragma once

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

}  // namespace etendue
