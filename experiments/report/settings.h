// How far methods' defaults are from the best of their own settings, at each time. Only where every method of the log stands
// by its name alone and with other settings beside it.
#pragma once

#include "experiments/report/kind_report.h"
#include "experiments/report/report_data.h"

namespace etendue {

// From a 64th of each scene's common time (ReportData) on. Table `settings`: a row a scene and method, with the most that the
// defaults' error is over the least of all settings; figure `settings`: that ratio over time.
KindReport settings_report(const ReportData& data);

}  // namespace etendue
