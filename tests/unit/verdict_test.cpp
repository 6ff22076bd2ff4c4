// The one rule by which predictions of all kinds of experiments are judged.
#include "experiments/statistics/verdict.h"

#include <gtest/gtest.h>

#include <vector>

namespace etendue {
namespace {

Verdict factor(double low, double high, double expected_low, double expected_high) {
  return judge(0.5 * (low + high), {low, high}, {expected_low, expected_high}, no_effect_of(FigureKind::factor));
}

TEST(Verdicts, FactorAboveOneIsJudgedByItsInterval) {
  EXPECT_EQ(factor(1.22, 1.28, 1.2, 1.3), Verdict::confirmed);
  EXPECT_EQ(factor(1.1, 1.2, 1.2, 1.3), Verdict::confirmed) << "they meet the interval";
  EXPECT_EQ(factor(1.1, 1.15, 1.2, 1.3), Verdict::weaker);
  EXPECT_EQ(factor(1.4, 1.5, 1.2, 1.3), Verdict::stronger);
  EXPECT_EQ(factor(0.98, 1.02, 1.2, 1.3), Verdict::refuted) << "no effect beyond the spread";
  EXPECT_EQ(factor(0.5, 0.6, 1.2, 1.3), Verdict::refuted) << "the opposite one";
  EXPECT_EQ(factor(0.9, 1.25, 1.2, 1.3), Verdict::undecided);
}

TEST(Verdicts, FactorBelowOneIsTheSameMirrored) {
  EXPECT_EQ(factor(0.55, 0.6, 0.5, 0.6), Verdict::confirmed);
  EXPECT_EQ(factor(0.7, 0.8, 0.5, 0.6), Verdict::weaker);
  EXPECT_EQ(factor(0.1, 0.2, 0.5, 0.6), Verdict::stronger);
  EXPECT_EQ(factor(0.9, 1.1, 0.5, 0.6), Verdict::refuted);
}

TEST(Verdicts, QualitativeOneNeedsAnEffectBeyondTheSpread) {
  EXPECT_EQ(factor(1.01, 1.02, 1, endless), Verdict::confirmed);
  EXPECT_EQ(factor(100, 200, 1, endless), Verdict::confirmed);
  EXPECT_EQ(factor(0.99, 1.02, 1, endless), Verdict::undecided);
  EXPECT_EQ(factor(0.9, 0.95, 1, endless), Verdict::refuted);
  EXPECT_EQ(factor(1, 1, 1, endless), Verdict::refuted) << "exactly none";
}

TEST(Verdicts, LittleEffectIsConfirmedWithinAndRefutedWithout) {
  EXPECT_EQ(factor(0.99, 1.005, 0, 1.01), Verdict::confirmed);
  EXPECT_EQ(factor(1.02, 1.03, 0, 1.01), Verdict::refuted);
  EXPECT_EQ(factor(0.9, 1.5, 0, 1.01), Verdict::undecided) << "the spread alone reaches it";
  EXPECT_EQ(factor(0.98, 1.03, 1, 1), Verdict::confirmed) << "none is expected";
  EXPECT_EQ(factor(1.02, 1.03, 1, 1), Verdict::refuted);
}

TEST(Verdicts, ShorterTimeThanExpectedIsStronger) {
  const auto time = [](double low, double high) {
    return judge(0.5 * (low + high), {low, high}, {0.08, 0.125}, no_effect_of(FigureKind::time));
  };
  EXPECT_EQ(time(0.09, 0.11), Verdict::confirmed);
  EXPECT_EQ(time(0.04, 0.06), Verdict::stronger);
  EXPECT_EQ(time(0.4, 0.6), Verdict::weaker);
}

TEST(Verdicts, CountIsInOrOut) {
  EXPECT_EQ(judge(64, {64, 64}, {64, 64}, {}), Verdict::confirmed);
  EXPECT_EQ(judge(65, {65, 65}, {64, 64}, {}), Verdict::refuted);
}

TEST(Verdicts, ValueIsConfirmedByAnIntervalThatHoldsIt) {
  const Expected value{-0.5, -0.5}, interval{-0.6, -0.5};
  EXPECT_EQ(judge(-0.45, {-0.52, -0.38}, value, {}), Verdict::confirmed);
  EXPECT_EQ(judge(-0.45, {-0.48, -0.42}, value, {}), Verdict::refuted);
  EXPECT_EQ(judge(-0.45, {-0.52, -0.38}, interval, {}), Verdict::undecided) << "only the two intervals meet";
}

TEST(Verdicts, DifferentOnesDepend) {
  using enum Verdict;
  EXPECT_EQ(combine(std::vector{weaker, weaker}), weaker);
  EXPECT_EQ(combine(std::vector{weaker, confirmed}), depends);
  EXPECT_EQ(count_verdicts(std::vector{weaker, confirmed, weaker}), "1 confirmed, 2 weaker");
}

}  // namespace
}  // namespace etendue
