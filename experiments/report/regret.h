// How much is lost by a choice.
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// A method's regret is its error over the least that any method of the experiment has at that time, at each scene's common time
// (ReportData), a quarter and a sixteenth of it. The choices of the method `auto` are judged, without which it is empty; what
// always taking one method loses stands beside them. The table `regret` has a row for each scene and time, `regrets` one for
// each method, with its median and worst over all of them.
KindReport regret_report(const ReportData& data);

// How far methods' defaults are from the best of their own settings, at each time, from a 64th of each scene's common time on.
// It is empty unless every method stands by its name alone and also with other settings. The table `settings` has a row for
// each scene and method, with the largest ratio of the defaults' error to the least of all settings; the figure has the ratio
// over time.
KindReport settings_report(const ReportData& data);

}  // namespace etendue
