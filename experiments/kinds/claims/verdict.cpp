#include "experiments/kinds/claims/verdict.h"

#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

namespace {

struct Range {
  double low, high;
};

bool overlap(const Range& a, const Range& b) { return a.low <= b.high && b.low <= a.high; }

// The claim is of more than `none`; mirrored for a claim of less.
ClaimVerdict judge_above(const Range& measured, const Range& claimed, double none) {
  const bool effect = measured.low > none;
  if (measured.low > claimed.high) return ClaimVerdict::stronger;
  const bool meets = measured.high >= claimed.low && measured.high > none;
  if (meets) return effect ? ClaimVerdict::confirmed : ClaimVerdict::undecided;
  return effect ? ClaimVerdict::weaker : ClaimVerdict::refuted;
}

Range mirrored(const Range& r) { return {-r.high, -r.low}; }

}  // namespace

std::string_view verdict_name(ClaimVerdict verdict) {
  constexpr std::string_view names[] = {"confirmed", "weaker", "stronger", "refuted", "undecided", "depends"};
  return names[static_cast<int>(verdict)];
}

ClaimVerdict judge(const ClaimFigure& figure) {
  CHECK(figure.judged);
  const Range measured{figure.value.low, figure.value.high}, claimed{figure.expected_low, figure.expected_high};
  const bool plain = figure.kind == FigureKind::plain;
  if (figure.kind == FigureKind::time) {  // shorter is more
    if (overlap(measured, claimed)) return ClaimVerdict::confirmed;
    return measured.high < claimed.low ? ClaimVerdict::stronger : ClaimVerdict::weaker;
  }
  if (!plain && claimed.low >= 1) return judge_above(measured, claimed, 1);
  if (!plain && claimed.high <= 1) return judge_above(mirrored(measured), mirrored(claimed), -1);
  if (figure.value.median >= claimed.low && figure.value.median <= claimed.high) return ClaimVerdict::confirmed;
  return overlap(measured, claimed) ? ClaimVerdict::undecided : ClaimVerdict::refuted;
}

ClaimVerdict combine(std::span<const ClaimVerdict> verdicts) {
  CHECK(!verdicts.empty());
  const bool same = std::all_of(verdicts.begin(), verdicts.end(), [&](ClaimVerdict v) { return v == verdicts.front(); });
  return same ? verdicts.front() : ClaimVerdict::depends;
}

}  // namespace etendue
