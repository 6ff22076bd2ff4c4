// A decision of the program held against its opposite on one scene: a component as it is, on or off, and switched, under each
// seed. The cell is (scene, method or structure, component, 1).
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/kind_report.h"
#include "experiments/statistics/statistics.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// Holds what was measured under one seed. Errors are relMSE; times are of the processor, preparation included.
struct LedgerTrial {
  std::uint64_t seed = 0;
  double error = 0, switched_error = 0;
  double cpu_s = 0, switched_cpu_s = 0;
  bool same_image = false;  // to the last bit
};

struct LedgerRecord final : KindRecord {
  static constexpr const char* type = "ledger";

  bool on = false;           // as the program decides
  std::string why;           // it does
  std::string switched;      // the method, structure or scene with the component switched
  std::string kept;          // why the decision stands where it is contradicted; "": nothing was said
  std::string inapplicable;  // why it cannot be switched here; "": it was
  std::string reference;     // what errors are measured against
  double relmse_floor = 0;   // the part of every error that is its noise; 0: none, not known, or an older line
  std::uint64_t iterations = 0;
  std::string bias;         // of the method: "unbiased", "consistent" or "biased",
  double mse_exponent = 0;  // and the power of the iterations at which its MSE falls
  std::vector<LedgerTrial> trials;

  std::string line() const override;
  bool uses_reference_of(const std::string& scene) const override { return !reference.empty() && cell.scene == scene; }
};

// The verdict on a decision of the program, from the error and the time with a component switched over those without.
//
//   earns its time   switched, the image takes longer to the same error
//   contradicted     switched, it takes less time to the same error
//   a trade          of a biased method: one way errs less and the other takes less time, and no time takes the bias away
//   costs nothing    neither error nor time differs by more than 5 %
//   no gain          nor loss of time to the same error beyond noise and 5 %, though error and time may differ each
//
// The time to an error is error^(-1 / e) x time, e the exponent at which the method's MSE falls with iterations. What `earns`,
// `contradicted` and `a trade` ask for is held to a level at which all decisions of a log together err in one of twenty logs.
enum class LedgerVerdict : std::uint8_t { earns_its_time, costs_nothing, no_gain, trade, contradicted };
constexpr std::size_t ledger_verdict_count = 5;

std::string_view verdict_name(LedgerVerdict verdict);

// Switched over decided, the noise of the reference taken from errors: geometric means over seeds, with their intervals, which
// are the values themselves below three seeds.
struct LedgerFigures {
  Estimate error, time, time_to_error;
  bool same_images = false;
};
// Errors below 1e-10 are rounding and count as that. At least one trial (CHECK).
LedgerFigures ledger_figures(const LedgerRecord& record, double confidence = 0.95);

// The verdict of one decision, where `decisions` of them are judged together.
LedgerVerdict judge_decision(const LedgerRecord& record, std::size_t decisions);

// Tables and chart: each component over all scenes, and each decision with its verdict.
KindReport ledger_report(const RunLog& log);
std::string ledger_summary(const RunLog& log);

}  // namespace etendue
