// What a report says of methods on the scenes that break them. Two things are predicted of each scene, and the median over
// seeds is judged:
//
//   as it is       the method fails, with a figure in the interval that the failure is expected to bring it to; no effect is
//                  the nearest figure of a method that does not fail, so that "refuted" says that nothing fails
//   with a remedy  it holds: nothing of the failure is left. No effect is that half of it is left, so that "weaker" says that
//                  the remedy brings the figure more than half of the way
#pragma once

#include "experiments/kinds/claims/claim_record.h"
#include "experiments/report/kind_report.h"

#include <string>
#include <vector>

namespace etendue {

// A row of the catalogue of failures as it was measured. Its first figure is the failing method's, the others are those of its
// remedies. The cell is (scene, figure, "stress-01", 1). `claim` is the failure in words, `claimed` what is measured of the
// image.
struct StressRecord final : ClaimRecord {
  static constexpr const char* type = "stress";

  Expected holds;                    // the figure of a method that does not fail
  std::vector<std::string> methods;  // of the figures
  std::string picture;               // beside the log: the reference, then each method
  FileStamp picture_stamp;

  std::string line() const override;
  File file() override { return {&picture, &picture_stamp}; }
};

// The first row is the method as it is, the others are those of its remedies. The record must be done (CHECK).
std::vector<JudgedPrediction> judge_stress(const StressRecord& record);

KindReport stress_report(const RunLog& log);    // its section has the pictures
std::string stress_summary(const RunLog& log);  // what `etendue stress` prints at its end

}  // namespace etendue
