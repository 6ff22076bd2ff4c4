// The curves of a log in long form, for programs: a row for each metric of each checkpoint of the cells that are done, with a
// column for each parameter of the methods. docs/log.md lists the columns.
#pragma once

#include "experiments/report/report_data.h"

#include <string>

namespace etendue {

std::string curves_csv(const ReportData& data);

}  // namespace etendue
