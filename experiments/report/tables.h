// The tables of a report, each the same data in every format.
//
//   predictions   what was expected, what was measured, and the verdict (predictions.h)
//   final         per scene, integrator and structure: the error at equal time, cost, every metric, theory against measurement
//   regret        what a method that chooses others loses by its choice, and what always taking one does (regret.h)
//   settings      what methods' defaults lose to the best of their own settings (settings.h)
//   phases        where the time went
//   counters      work per iteration, which no clock's noise touches
//   structures    what `etendue accel` measured of the ray structures
//   elsewhere     what others measured of the same scenes, and the best here at that time
//   references    what the errors are measured against, and its own noise
//   expectations  what each integrator declares of itself
//   failures      cells that failed, with their errors
//   manifest      what ran: version, compiler, machine
#pragma once

#include "experiments/report/report_data.h"
#include "experiments/report/table_format.h"

#include <string>
#include <vector>

namespace etendue {

Table final_table(const ReportData& data);
Table phases_table(const ReportData& data);
Table counters_table(const ReportData& data);
Table structures_table(const ReportData& data);
Table elsewhere_table(const ReportData& data);
Table references_table(const ReportData& data);
Table expectations_table(const ReportData& data);
Table failures_table(const ReportData& data);
Table manifest_table(const ReportData& data);
std::vector<Table> report_tables(const ReportData& data);

// The curves of a log in long form, for programs: a row for each metric of each checkpoint of the cells that are done, with a
// column for each parameter of the methods. docs/log.md lists the columns.
std::string curves_csv(const ReportData& data);

// The summary that `etendue run` prints at its end: per scene the errors at equal time, the verdict, and warnings.
std::string summary_table(const RunLog& log);

}  // namespace etendue
