// Holds what a report shows of the records of one kind of experiment, or of what stands beside them: rates, ray structures. All
// of it is empty where the log has none.
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/charts/charts.h"
#include "experiments/report/predictions.h"
#include "experiments/report/table_format.h"

#include <string>
#include <utility>
#include <vector>

namespace etendue {

// Figures below one heading of the page; without a heading, each one's caption says what it is of.
struct FigureGroup {
  std::string heading = {};
  std::vector<Figure> figures = {};
  std::string below = {};  // HTML
};

struct KindReport {
  std::string fact = {};  // beneath the page's title: "3 animations"
  std::vector<Table> tables = {};
  Predictions predictions = {};
  std::vector<std::pair<std::string, std::string>> findings = {};  // what of, and a sentence
  std::string answer = {};  // all of that in one sentence of about answer_width (verdicts.h)
  // The page's section: the name that links to it, its heading, HTML, and figures, which are kept as files, too.
  std::string id = {}, heading = {}, section = {};
  std::vector<FigureGroup> figures = {};
};

// Writes a line for each cell that failed.
template <class Record>
std::vector<std::string> failed_cells(const RunLog& log) {
  std::vector<std::string> lines;
  for (const Record* record : records_of<Record>(log))
    if (!record->done()) lines.push_back("Failed: " + record->cell.key() + ": " + record->error);
  return lines;
}

}  // namespace etendue
