// The verdict on a claim, by one rule, from the quartiles of the measured figure and the claimed interval:
//
//   confirmed  the quartiles meet the claimed interval (at an end that is no effect at all they must lie beyond it)
//   weaker     an effect of the claimed direction, but less than claimed
//   stronger   more than claimed
//   refuted    no effect beyond the spread, or the opposite one
//   undecided  the spread reaches from no effect into the claimed interval
//   depends    several figures or scenes, whose verdicts differ
//
// A claim of no direction (a count, or of little effect: an interval around none) is confirmed where the median lies in its
// interval, undecided where only the quartiles meet it, refuted otherwise.
//
// "No effect" is a factor of 1, and for a time, infinity: a shorter time than claimed is "stronger".
#pragma once

#include "experiments/kinds/claims/claim_record.h"

#include <span>

namespace etendue {

enum class ClaimVerdict : std::uint8_t { confirmed, weaker, stronger, refuted, undecided, depends };

std::string_view verdict_name(ClaimVerdict verdict);

// The verdict on one figure, which must be judged (CHECK).
ClaimVerdict judge(const ClaimFigure& figure);

// The verdict on all of at least one (CHECK).
ClaimVerdict combine(std::span<const ClaimVerdict> verdicts);

}  // namespace etendue
