// A sweep along a hazard's parameter: where a method first fails, found by bisection, with an interval.
//
// The parameter runs from its harmless end (t = 0) to its harmful one (t = 1), evenly in its logarithm. All points lie on a
// lattice of 2^depth steps, so that methods share scenes and references. The ends and the quarters are measured first, whatever
// they say, so that a curve which recovers is found out; then the quarter of the first failure is halved until a step is no
// wider than the factor asked for. A point fails where the mean of its figure over seeds lies outside the interval of a sound
// method.
//
// The threshold lies between the last point that holds and the first that fails, where the mean crosses the bound, linear in t
// (in the figure's logarithm where it is positive). Its interval is that in which 95 % of repetitions with as many other seeds
// have theirs: that of the bootstrap over seeds ([Efron1993] ch. 13), or of the noise at the threshold over the curve's slope
// where that is wider, sqrt(2) times as wide about the threshold, as a repetition has its own noise; and never narrower than
// the step.
#pragma once

#include "experiments/config/expected.h"
#include "experiments/statistics/statistics.h"

#include <functional>
#include <span>
#include <vector>

namespace etendue {

struct SweepRange {
  double from = 1, to = 10;  // harmless and harmful, both positive; either may be the larger
  bool whole = false;        // numbers of something

  double at(double t) const;       // with six digits
  double t_of(double x) const;     // outside [0, 1] for an x outside of the range
  int depth(double factor) const;  // of the lattice whose steps are no wider; at least that of quarters
};

struct SweepPoint {
  double t = 0, x = 0;
  std::vector<double> values;  // by seed
};

enum class Holding : std::uint8_t { to_the_end, up_to, nowhere };

struct Threshold {
  Holding holding = Holding::to_the_end;
  double t = 1;                 // 0: fails at the harmless end; 1: holds to the end
  Interval interval = {1, 1};   // of t; an end at 0 or 1 is open: the range says no more
  double held = 0, failed = 1;  // the points between which it lies; the same where it holds to the end or nowhere
  bool is_monotone = true;      // nothing holds beyond the first failure
};

// Points ascend in t. measure(x) gives a figure for each seed.
std::vector<SweepPoint> sweep(const SweepRange& range, double factor, const Expected& holds,
                              const std::function<std::vector<double>(double x)>& measure);

// How far a figure lies beyond its bounds: positive where it fails. A positive figure is infinitely (1e300) far from a bound of
// 0. Where the bounds lie on both sides of 0 the distance is a difference, else that of logarithms, so that both bounds have
// one unit.
double excess(double value, const Expected& holds);
bool is_failed(const SweepPoint& point, const Expected& holds);
Threshold threshold_of(std::span<const SweepPoint> points, const Expected& holds);

// Says by how much a remedy moved a threshold, as a factor of x towards harm, which is above 1 where it helps. An end that one
// of the two holds to bounds the factor from one side only; of two that hold to the same end nothing is known.
struct Mended {
  double factor = 1;
  Interval interval = {1, 1};  // its other end is 0 or infinite where the factor is bounded from one side only
  bool at_least = false, at_most = false;

  bool is_known() const { return !(at_least && at_most); }
};
// The seeds of both are the same and are resampled together.
Mended mended(std::span<const SweepPoint> without, std::span<const SweepPoint> with, const Expected& holds,
              const SweepRange& range);

}  // namespace etendue
