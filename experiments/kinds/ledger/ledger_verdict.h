// The verdict on a decision of the program, from the error and the time with a component switched over those without.
//
//   earns its time   switched, the image takes longer to the same error
//   contradicted     switched, it takes less time to the same error
//   a trade          of a biased method: one way errs less and the other takes less time, and no time takes the bias away
//   costs nothing    neither error nor time differs by more than 5 %
//   no difference    none beyond noise and 5 %
//
// The time to an error is error^(-1 / e) x time, e the exponent at which the method's MSE falls with iterations. What `earns`,
// `contradicted` and `a trade` ask for is held to a level at which all decisions of a log together err in one of twenty logs.
#pragma once

#include "experiments/kinds/ledger/ledger_record.h"
#include "experiments/statistics/statistics.h"

#include <string_view>

namespace etendue {

enum class LedgerVerdict : std::uint8_t { earns_its_time, costs_nothing, no_difference, trade, contradicted };
constexpr std::size_t ledger_verdict_count = 5;

std::string_view verdict_name(LedgerVerdict verdict);

// Switched over decided: geometric means over seeds, with their intervals, which are the values themselves below three seeds.
struct LedgerFigures {
  Estimate error, time, time_to_error;
  bool same_images = false;
};
// Errors below 1e-10 are rounding and count as that. At least one trial (CHECK).
LedgerFigures ledger_figures(const LedgerRecord& record, double confidence = 0.95);

// The verdict of one decision, where `decisions` of them are judged together.
LedgerVerdict judge_decision(const LedgerRecord& record, std::size_t decisions);

}  // namespace etendue
