// Is one method better than another, or is that chance? Mann and Whitney's test of two samples by ranks ([Mann1947]): it asks
// nothing of how errors are distributed, so that a single firefly among the seeds weighs no more than any other seed.
//
// It is exact for up to forty values in all: the distribution of the rank sum over all ways to draw one sample from both, with
// the mean rank for equal values. Beyond, it is normal, with the variance that equal values leave and the continuity
// correction. What no arrangement can show, no test finds: two samples of three give p = 0.1 at least, two of four 0.029.
// From nine each on p may fall to 4e-5, so that a dozen comparisons held together by Sidak's correction can still tell.
#pragma once

#include <cstddef>
#include <span>

namespace etendue {

inline constexpr std::size_t enough_replicates = 9;  // of each; a report warns below

struct RankTest {
  double p = 1;        // two-sided: as far from even, or farther, by chance
  double share = 0.5;  // how often a value of `a` is less than one of `b`, equal ones counted half
  bool is_exact = true;
};

RankTest rank_test(std::span<const double> a, std::span<const double> b);  // CHECKs that neither is empty

}  // namespace etendue
