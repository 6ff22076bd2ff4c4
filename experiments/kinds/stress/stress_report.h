// The report's verdicts on methods on the scenes that break them, by one rule, from the median over seeds of the row's figure:
//
//   fails as expected   the method's figure lies in the interval that the failure is expected to bring it to
//   holds               it lies in the interval of a method that does not fail
//   fails otherwise     in neither
//
// and of a remedy: it holds; or it helps, having brought the figure at least half of the way to where it would hold; or it does
// not help.
#pragma once

#include "experiments/kinds/stress/stress_record.h"
#include "experiments/report/kind_report.h"

#include <string>
#include <vector>

namespace etendue {

enum class StressVerdict : std::uint8_t { fails_as_expected, fails_otherwise, holds, helps, no_help };

std::string_view verdict_name(StressVerdict verdict);

// The verdict on the first figure, then those on the remedies'. The record must be done (CHECK).
std::vector<StressVerdict> judge_stress(const StressRecord& record);

// The rows that are done, by id.
std::vector<const StressRecord*> arrange_stress(const RunLog& log);

Table stress_table(const RunLog& log);
KindReport stress_report(const RunLog& log);    // its section has the pictures
std::string stress_summary(const RunLog& log);  // what `etendue stress` prints at its end

}  // namespace etendue
