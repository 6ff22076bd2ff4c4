// The verdict on a prediction, by one rule for all kinds of experiments: the measured value, with its interval, against what
// was expected.
//
//   confirmed  the measured interval meets the expected one (at an end that is no effect at all it must lie beyond it)
//   weaker     an effect of the expected direction, but less than expected
//   stronger   more than expected
//   refuted    no effect beyond the spread, or the opposite one
//   undecided  the spread reaches from no effect into the expected interval, or is not known
//   depends    several predictions, whose verdicts differ
//
// What has no direction (a count, a share, no effect, or little: an interval around none) is confirmed where the measured value
// lies in the expected interval, or the measured interval holds the expected value; undecided where only the two intervals
// meet; refuted otherwise.
//
// "No effect" is a factor of 1, and for a time, infinity: a shorter time than expected is "stronger".
#pragma once

#include "experiments/config/expected.h"
#include "experiments/statistics/statistics.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace etendue {

enum class Verdict : std::uint8_t { confirmed, weaker, stronger, refuted, undecided, depends };

std::string_view verdict_name(Verdict verdict);

// `no_effect` is the value that the quantity has without any effect, where it has such a value.
Verdict judge(double value, const Interval& measured, const Expected& expected, std::optional<double> no_effect);

// The verdict on all of at least one (CHECK).
Verdict combine(std::span<const Verdict> verdicts);

// Writes "6 confirmed, 1 refuted".
std::string count_verdicts(std::span<const Verdict> verdicts);

// The kind of a quantity, which says how it is written and which of its values is no effect.
enum class FigureKind : std::uint8_t { factor, time, plain, share, exponent };

// 1 for a factor, infinity for a time in seconds, none for the others.
std::optional<double> no_effect_of(FigureKind kind);

}  // namespace etendue
