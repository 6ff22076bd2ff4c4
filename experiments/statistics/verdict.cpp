#include "experiments/statistics/verdict.h"

#include "framework/core/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace etendue {

namespace {

// More than `none` is expected; mirrored where less is.
Verdict judge_above(const Interval& measured, const Interval& expected, double none) {
  const bool effect = measured.low > none;
  if (measured.low > expected.high) return Verdict::stronger;
  const bool meets = measured.high >= expected.low && measured.high > none;
  if (meets) return effect ? Verdict::confirmed : Verdict::undecided;
  return effect ? Verdict::weaker : Verdict::refuted;
}

Verdict judge_within(double value, const Interval& measured, const Expected& expected) {
  const bool meets = measured.low <= expected.high && expected.low <= measured.high;
  if (expected.contains(value) || (meets && expected.is_value())) return Verdict::confirmed;
  return meets ? Verdict::undecided : Verdict::refuted;
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  constexpr std::string_view names[] = {"confirmed", "weaker", "stronger", "refuted", "undecided", "depends"};
  return names[static_cast<int>(verdict)];
}

Verdict judge(double value, const Interval& measured, const Expected& expected, std::optional<double> no_effect) {
  if (expected.is_value() && expected.low == no_effect) return judge_within(value, measured, expected);  // none is expected
  if (no_effect && expected.low >= *no_effect) return judge_above(measured, {expected.low, expected.high}, *no_effect);
  if (no_effect && expected.high <= *no_effect)
    return judge_above({-measured.high, -measured.low}, {-expected.high, -expected.low}, -*no_effect);
  return judge_within(value, measured, expected);
}

Verdict combine(std::span<const Verdict> verdicts) {
  CHECK(!verdicts.empty());
  const bool same = std::ranges::all_of(verdicts, [&](Verdict v) { return v == verdicts.front(); });
  return same ? verdicts.front() : Verdict::depends;
}

std::string count_verdicts(std::span<const Verdict> verdicts) {
  std::map<Verdict, int> counts;
  for (const Verdict verdict : verdicts) ++counts[verdict];
  return joined(counts, ", ", [](const auto& of) { return fmt::format("{} {}", of.second, verdict_name(of.first)); });
}

std::optional<double> no_effect_of(FigureKind kind) {
  if (kind == FigureKind::factor) return 1;
  if (kind == FigureKind::time) return endless;
  return std::nullopt;
}

}  // namespace etendue
