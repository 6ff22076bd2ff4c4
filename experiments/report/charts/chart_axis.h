// Axes of a chart: ranges, ticks and what stands beside them.
#pragma once

#include "experiments/statistics/statistics.h"

#include <string>
#include <vector>

namespace etendue {

enum class Scale : std::uint8_t { linear, log };

struct Tick {
  double value = 0;
  std::string label;  // empty: a minor tick
};

// Ticks within [low, high], ascending, with about `most` labels: decades, or 1-2-5 where there are few, on log axes; a step of
// 1, 2 or 5 on linear ones. low < high, and low > 0 on a log axis.
std::vector<Tick> ticks(Interval range, Scale scale, int most);

// Where `value` lies between the ends of the range: 0 to 1 inside it. Values at or below 0 lie at minus infinity of a log axis.
double position(double value, Interval range, Scale scale);

// A range that shows all values with a little air; on a log axis of the positive ones. It is never empty.
Interval padded_range(const std::vector<double>& values, Scale scale);

}  // namespace etendue
