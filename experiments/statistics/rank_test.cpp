#include "experiments/statistics/rank_test.h"

#include "framework/core/check.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace etendue {

namespace {

constexpr std::size_t most_exact = 40;  // values in all

// Twice the ranks of both samples, `a` first: whole numbers, with the mean rank for equal values.
std::vector<std::size_t> doubled_ranks(std::span<const double> a, std::span<const double> b) {
  std::vector<double> values(a.begin(), a.end());
  values.insert(values.end(), b.begin(), b.end());
  std::vector<std::size_t> ranks;
  for (const double value : values) {
    const auto less = std::ranges::count_if(values, [&](double v) { return v < value; });
    const auto equal = std::ranges::count(values, value);
    ranks.push_back(static_cast<std::size_t>(2 * less + equal + 1));
  }
  return ranks;
}

// The share of all ways to draw `count` of the ranks whose sum lies at least as far from the mean as `sum` does.
double exact_p(const std::vector<std::size_t>& ranks, std::size_t count, std::size_t sum) {
  std::size_t total = 0;
  for (const std::size_t rank : ranks) total += rank;
  // ways[n][s]: to draw n of the ranks so far, with sum s. Below 2^53 they are exact.
  std::vector<std::vector<double>> ways(count + 1, std::vector<double>(total + 1, 0));
  ways[0][0] = 1;
  for (const std::size_t rank : ranks)
    for (std::size_t n = count; n > 0; --n)
      for (std::size_t s = total; s + 1 > rank; --s) ways[n][s] += ways[n - 1][s - rank];
  // Scaled by N, so that there are whole numbers on both sides.
  const auto off = [&](std::size_t s) {
    const auto scaled = static_cast<double>(s * ranks.size()), mean = static_cast<double>(count * total);
    return std::abs(scaled - mean);
  };
  double far = 0, all = 0;
  for (std::size_t s = 0; s <= total; ++s) {
    all += ways[count][s];
    if (off(s) >= off(sum)) far += ways[count][s];
  }
  return far / all;
}

double normal_p(const std::vector<std::size_t>& ranks, std::size_t count, std::size_t sum) {
  const auto n = static_cast<double>(count), all = static_cast<double>(ranks.size()), m = all - n;
  double squares = 0;  // of the ranks about their mean, which equal values make less
  for (const std::size_t rank : ranks) squares += std::pow(static_cast<double>(rank) / 2 - (all + 1) / 2, 2);
  const double variance = n * m * squares / (all * (all - 1));
  if (variance == 0) return 1;
  const double off = std::abs(static_cast<double>(sum) / 2 - n * (all + 1) / 2) - 0.5;
  if (off <= 0) return 1;
  return std::erfc(off / std::sqrt(2 * variance));
}

}  // namespace

RankTest rank_test(std::span<const double> a, std::span<const double> b) {
  CHECK(!a.empty() && !b.empty());
  const std::vector<std::size_t> ranks = doubled_ranks(a, b);
  std::size_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += ranks[i];
  const auto n = static_cast<double>(a.size()), m = static_cast<double>(b.size());
  const double larger = static_cast<double>(sum) / 2 - n * (n + 1) / 2;  // pairs in which a is the larger: U
  RankTest test{.share = 1 - larger / (n * m), .is_exact = ranks.size() <= most_exact};
  test.p = test.is_exact ? exact_p(ranks, a.size(), sum) : normal_p(ranks, a.size(), sum);
  return test;
}

}  // namespace etendue
