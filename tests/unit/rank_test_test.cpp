// Mann and Whitney's test against p that can be counted by hand, and against its own error rate.
#include "experiments/statistics/rank_test.h"
#include "framework/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace etendue {
namespace {

using Values = std::vector<double>;

TEST(RankTest, SamplesApartHaveTheLeastP) {
  const RankTest three = rank_test(Values{1, 2, 3}, Values{4, 5, 6});
  EXPECT_DOUBLE_EQ(three.p, 2.0 / 20);
  EXPECT_EQ(three.share, 1);
  EXPECT_TRUE(three.is_exact);
  EXPECT_DOUBLE_EQ(rank_test(Values{9, 8, 7, 6}, Values{1, 2, 3, 4}).p, 2.0 / 70);
  EXPECT_EQ(rank_test(Values{9, 8, 7, 6}, Values{1, 2, 3, 4}).share, 0);
  EXPECT_DOUBLE_EQ(rank_test(Values{1}, Values{2}).p, 1);
}

// Four of the ten ways to draw two of {1, 2, 3, 4, 5} have a rank sum of at most 4 or at least 8: {1,2} {1,3} {3,5} {4,5}.
TEST(RankTest, CountsWhatLiesAsFarOrFarther) {
  EXPECT_DOUBLE_EQ(rank_test(Values{10, 30}, Values{20, 40, 50}).p, 0.4);
  EXPECT_DOUBLE_EQ(rank_test(Values{20, 40, 50}, Values{10, 30}).p, 0.4) << "it has no side";
}

TEST(RankTest, EqualValuesShareTheirRank) {
  EXPECT_DOUBLE_EQ(rank_test(Values{2, 2}, Values{2, 2, 2}).p, 1);
  EXPECT_DOUBLE_EQ(rank_test(Values{2, 2}, Values{2, 2, 2}).share, 0.5);
  // Ranks 1, 2.5 against 2.5, 4: of six draws {1, 2.5} twice and {2.5, 4} twice lie as far.
  EXPECT_DOUBLE_EQ(rank_test(Values{1, 5}, Values{5, 9}).p, 4.0 / 6);
  const Values same(30, 1.0);
  EXPECT_EQ(rank_test(same, same).p, 1) << "beyond what is counted, too";
}

TEST(RankTest, NormalMeetsExactWhereTheyMeet) {
  Values a, b;
  Pcg32 rng(3, 1);
  for (int i = 0; i < 20; ++i) {
    a.push_back(rng.next_float());
    b.push_back(rng.next_float() + 0.25);
  }
  const RankTest exact = rank_test(a, b);
  b.push_back(rng.next_float() + 0.25);
  const RankTest normal = rank_test(a, b);
  EXPECT_TRUE(exact.is_exact);
  EXPECT_FALSE(normal.is_exact);
  EXPECT_NEAR(std::log(normal.p / exact.p), 0, 0.6);
}

TEST(RankTest, ErrsAsOftenAsItSays) {
  Pcg32 rng(11, 2);
  for (const std::size_t n : {9u, 25u}) {
    constexpr int tests = 2000;
    int found = 0;
    for (int i = 0; i < tests; ++i) {
      Values a, b;
      for (std::size_t k = 0; k < n; ++k) {
        a.push_back(1 / (1e-6 + rng.next_float()));  // with a tail that has no mean
        b.push_back(1 / (1e-6 + rng.next_float()));
      }
      found += rank_test(a, b).p <= 0.05;
    }
    EXPECT_NEAR(found, 0.05 * tests, 4 * std::sqrt(0.05 * 0.95 * tests)) << n;
  }
}

}  // namespace
}  // namespace etendue
