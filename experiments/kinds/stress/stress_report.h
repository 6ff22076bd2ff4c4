// What a report says of methods on the scenes that break them. Two things are predicted of each scene, and the median over
// seeds is judged:
//
//   as it is       the method fails, with a figure in the interval that the failure is expected to bring it to; no effect is
//   the
//                  nearest figure of a method that does not fail, so that "refuted" says that nothing fails
//   with a remedy  it holds: nothing of the failure is left. No effect is that half of it is left, so that "weaker" says that
//                  the remedy brings the figure more than half of the way
#pragma once

#include "experiments/kinds/stress/stress_record.h"
#include "experiments/report/kind_report.h"

#include <string>
#include <vector>

namespace etendue {

// The first row is the method as it is, the others are those of its remedies. The record must be done (CHECK).
std::vector<JudgedPrediction> judge_stress(const StressRecord& record);

KindReport stress_report(const RunLog& log);    // its section has the pictures
std::string stress_summary(const RunLog& log);  // what `etendue stress` prints at its end

}  // namespace etendue
