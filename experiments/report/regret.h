// How much is lost by a choice of method: its error over the least that any method of the experiment has at that time. Only
// where the log has the method `auto`, whose choices are what this judges; beside it stands what always taking one method
// loses.
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// At each scene's common time (ReportData), a quarter and a sixteenth of it. Table `regret`: a row a scene and time; `regrets`:
// a row a method, with its median and worst over all of them. Empty without `auto`.
KindReport regret_report(const ReportData& data);

}  // namespace etendue
