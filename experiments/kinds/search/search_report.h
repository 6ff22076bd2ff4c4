// Tables and charts of point and record structures: times and memory, which one leads where, and where one overtakes another.
#pragma once

#include "experiments/kinds/search/search_record.h"
#include "experiments/report/kind_report.h"

namespace etendue {

Table search_times_table(const RunLog& log);       // a row for each set, count and structure
Table search_leaders_table(const RunLog& log);     // a row for each set, measure and count: the fastest and the next
Table search_crossovers_table(const RunLog& log);  // a row for each crossing

// Charts over the count, the number of neighbours and the variation, and maps of which structure leads.
std::vector<Figure> search_figures(const RunLog& log);

// A sentence for each set of largest count and each measure.
std::vector<std::pair<std::string, std::string>> search_findings(const RunLog& log);

KindReport search_report(const RunLog& log);

// What `etendue run` prints at its end.
std::string search_summary(const RunLog& log);

}  // namespace etendue
