#include "integrators/caches/records/cache_progress.h"

#include <gtest/gtest.h>

#include <cmath>

namespace etendue {
namespace {

TEST(CacheProgress, StepAddsNoMoreThanATenthOfADoublingOrOnePass) {
  const CacheProgress progress;
  double passes = progress.passes_at(CacheProgress::overture_rounds);
  for (std::uint32_t i = CacheProgress::overture_rounds + 1; i < 30'000; ++i) {
    const double next = progress.passes_at(i);
    ASSERT_EQ(progress.steps_at(i), next > passes) << i;
    ASSERT_LE(next - passes, std::max(1 + 1e-9, 0.05 * passes)) << i;
    if (passes >= 22) {
      ASSERT_LE(std::floor(next) - std::floor(passes), 1) << i;
    }
    passes = next;
  }
  EXPECT_GT(passes, 60);
}

TEST(CacheProgress, AccuracyAfterIsThatOfTheNextStep) {
  const CacheProgress progress;
  std::uint32_t asked = 0;  // iterations since the last step
  for (std::uint32_t i = 1; i < 10'000; ++i) {
    if (i > CacheProgress::overture_rounds && !progress.steps_at(i)) continue;
    for (; asked < i; ++asked)
      ASSERT_NEAR(progress.accuracy_after(asked), progress.accuracy_at(i), 1e-6) << asked << " before " << i;
  }
}

TEST(CacheProgress, WithoutRefinementNothingChanges) {
  const CacheProgress progress{.accuracy = 0.1f, .refines = false};
  for (const std::uint32_t i : {0u, 3u, 5u, 1000u}) {
    EXPECT_EQ(progress.accuracy_at(i), 0.1f);
    EXPECT_EQ(progress.accuracy_after(i), 0.1f);
    EXPECT_EQ(progress.passes_at(i), 1);
    EXPECT_FALSE(progress.steps_at(i));
  }
}

}  // namespace
}  // namespace etendue
