#include "experiments/kinds/timing.h"

#include "experiments/statistics/statistics.h"

namespace etendue {

Times take_turns(const std::vector<TimedWork>& works, int repetitions, const std::function<void(double share)>& progress) {
  Times times(works.size());
  for (const TimedWork& work : works) work();
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    for (std::size_t i = 0; i < works.size(); ++i) {
      const std::size_t turn = (i + static_cast<std::size_t>(repetition)) % works.size();
      times[turn].push_back(works[turn]());
    }
    if (progress) progress((repetition + 1.0) / repetitions);
  }
  return times;
}

Measured summarise(std::span<const double> values) {
  if (values.empty()) return {};
  return {median(values), quantile(values, 0.25), quantile(values, 0.75)};
}

std::vector<double> ratios(std::span<const double> a, std::span<const double> b) {
  std::vector<double> result;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (b[i] > 0) result.push_back(a[i] / b[i]);
  return result;
}

}  // namespace etendue
