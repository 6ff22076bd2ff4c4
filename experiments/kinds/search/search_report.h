// Tables and charts of point and record structures: times and memory, which one leads where, and where one overtakes another.
#pragma once

#include "experiments/kinds/search/measure_search.h"
#include "experiments/report/kind_report.h"

namespace etendue {

KindReport search_report(const RunLog& log);
std::string search_summary(const RunLog& log);     // what `etendue run` prints at its end
Table search_crossovers_table(const RunLog& log);  // a row for each crossing

}  // namespace etendue
