// What a report shows of the records of one kind of experiment. All of it is empty where the log has none.
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/charts.h"
#include "experiments/report/predictions.h"
#include "experiments/report/table_format.h"

#include <string>
#include <utility>
#include <vector>

namespace etendue {

struct KindReport {
  std::string fact = {};  // beneath the page's title: "3 animations"
  std::vector<Table> tables = {};
  Predictions predictions = {};
  std::vector<Figure> figures = {};                                // that are kept as files
  std::vector<std::pair<std::string, std::string>> findings = {};  // what of, and a sentence
  // The page's section: the name that links to it, its heading, and its HTML.
  std::string id = {}, heading = {}, section = {};
  bool finds_in_section = false;  // the section says all that was found
  std::string answer = {};        // all of that in one sentence
};

// A line for each cell that failed.
template <class Record>
std::vector<std::string> failed_cells(const RunLog& log) {
  std::vector<std::string> lines;
  for (const Record* record : records_of<Record>(log))
    if (!record->done()) lines.push_back("Failed: " + record->cell.key() + ": " + record->error);
  return lines;
}

}  // namespace etendue
