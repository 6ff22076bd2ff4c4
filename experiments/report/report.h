// Tables, charts and report.html from logs alone.
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/charts/charts.h"
#include "experiments/report/table_format.h"

#include <string>
#include <vector>

namespace etendue {

struct ReportOptions {
  std::vector<std::string> table_formats{"md", "csv", "tex"};
  bool check_files = true;  // hold images and references against the log; else nothing but the log is read
  bool latex = false;       // write latex/ as well: charts that pgfplots draws
  bool of_a_run = false;    // by the run itself, which has looked at its scenes and knows of its shards
};

struct Report {
  std::vector<std::string> files;     // that were written
  std::vector<std::string> findings;  // what is missing or not to be believed; the page states it as well
  std::vector<std::string> notes;     // what was put right
};

// The log of a directory that `etendue run` wrote, the files it names found from here. Throws Error.
RunLog read_resolved_log(const std::string& directory);

// Holds what a log alone tells: the tables and charts that write_report writes, and its answer to the experiment's question in
// one sentence. Throws Error.
struct LogAnswers {
  std::vector<Table> tables;
  std::vector<Figure> figures;
  std::string answer;
  RunLog log;
};
LogAnswers answers_of(const std::string& directory);

// `directories` hold runs.jsonl (and the images and references it names); several are merged. Cells that are not to be believed
// count as failed. Writes tables/ (with curves.csv where that is a format of theirs), charts/ and report.html into `output`,
// replacing what stood there; and viewer/, pixels of images that would make the page too large.
Report write_report(const std::vector<std::string>& directories, const std::string& output, const ReportOptions& options = {});

// The curves of the logs in `directories` (tables.h), of cells as the logs alone have them. Throws Error.
std::string curves_of(const std::vector<std::string>& directories);

}  // namespace etendue
