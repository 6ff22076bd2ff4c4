// How far methods' defaults are from the best of their own settings, at each time. A log has this only where every method
// stands by its name alone and also with other settings.
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// Errors are compared from a 64th of each scene's common time (ReportData) on. The table `settings` has a row for each scene
// and method, with the largest ratio of the defaults' error to the least of all settings; the figure has the ratio over time.
KindReport settings_report(const ReportData& data);

}  // namespace etendue
