// How much is lost by a choice of method: its error over the least that any method of the experiment has at that time. A log
// has this only with the method `auto`, whose choices are judged; what always taking one method loses stands beside it.
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// Errors are compared at each scene's common time (ReportData), a quarter and a sixteenth of it. The table `regret` has a row
// for each scene and time, `regrets` one for each method, with its median and worst over all of them. It is empty without
// `auto`.
KindReport regret_report(const ReportData& data);

}  // namespace etendue
