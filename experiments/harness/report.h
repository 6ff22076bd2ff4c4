// Tables, charts and report.html from logs alone.
#pragma once

#include "experiments/harness/log.h"

#include <string>
#include <vector>

namespace etendue {

struct ReportOptions {
  std::vector<std::string> table_formats{"md", "csv", "tex"};
};

// The log of a directory that `etendue run` wrote, the files it names found from here. Throws Error.
RunLog read_resolved_log(const std::string& directory);

// `directories` hold runs.jsonl (and the images and references it names); several are merged. Writes tables/, charts/ and
// report.html into `output`, replacing what stood there. Returns the paths written.
std::vector<std::string> write_report(const std::vector<std::string>& directories, const std::string& output,
                                      const ReportOptions& options = {});

}  // namespace etendue
