#include "integrators/caches/records/cache_progress.h"

#include "framework/core/sampler.h"
#include "integrators/caches/records/record_file.h"

#include <gtest/gtest.h>

#include <cmath>

namespace etendue {
namespace {

constexpr std::uint32_t first = CacheProgress::overture_stages;  // stage of all rays

TEST(CacheProgress, StageAddsNoMoreThanATenthOfADoublingOrOnePass) {
  const CacheProgress progress;
  double passes = progress.passes_at(first);
  EXPECT_EQ(passes, 1);
  for (std::uint32_t i = first + 1; i < 200; ++i) {
    const double next = progress.passes_at(i);
    ASSERT_GT(next, passes) << i;
    ASSERT_LE(next - passes, std::max(1 + 1e-9, 0.05 * passes)) << i;
    if (passes >= 22) {
      ASSERT_EQ(std::floor(next) - std::floor(passes), 1) << i;
    }
    ASSERT_LT(progress.accuracy_at(i), progress.accuracy_at(i - 1)) << i;
    passes = next;
  }
  EXPECT_GT(passes, 60);
}

TEST(CacheProgress, OvertureIsCoarseAndHasFewRaysButSome) {
  const CacheProgress progress;
  for (std::uint32_t i = 0; i < first; ++i) {
    EXPECT_GT(progress.accuracy_at(i), progress.accuracy_at(i + 1));
    EXPECT_EQ(4 * progress.rays_at(i, 256), progress.rays_at(i + 1, 256));
    EXPECT_LT(progress.weight_at(i), progress.weight_at(i + 1));
  }
  EXPECT_EQ(progress.rays_at(first, 256), 256);
  EXPECT_EQ(progress.rays_at(0, 64), 16);
  EXPECT_EQ(progress.rays_at(0, 5), 5);
}

TEST(CacheProgress, AMapOfManyPhotonsIsBehindRaysUntilItIsWhole) {
  const auto photons_at = [](int photons, std::uint32_t stage) {
    return CacheProgress{.map_photons = photons}.photon_share_at(stage) * static_cast<float>(photons);
  };
  EXPECT_EQ(photons_at(100000, first), 100000);
  EXPECT_EQ(photons_at(100000, first - 1), 25000);
  EXPECT_NEAR(photons_at(200000, first), 50000, 1);
  EXPECT_NEAR(photons_at(200000, first - 2), 3125, 1);
  EXPECT_EQ(photons_at(200000, first + 1), 200000);
  EXPECT_EQ(photons_at(800000, first), 100000);
  EXPECT_NEAR(photons_at(2000000, first), 50000, 1);
  EXPECT_EQ(photons_at(2000000, first + 1), 250000);

  const CacheProgress progress{.map_photons = 2000000}, plain;
  for (std::uint32_t i = 0; i < first + 2; ++i) {
    EXPECT_EQ(progress.rays_at(i, 256), plain.rays_at(i, 256));
    EXPECT_LT(progress.weight_at(i), progress.weight_at(i + 1));
  }
  for (const std::uint32_t i : {first + 2, first + 9}) EXPECT_EQ(progress.weight_at(i), plain.weight_at(i));
}

TEST(CacheProgress, WithNewPhotonsInEveryIterationStagesFollowIterations) {
  const CacheProgress progress;
  EXPECT_EQ(progress.stage_after(0), first);
  EXPECT_EQ(progress.stage_after(50), first + 10);
  EXPECT_EQ(progress.stage_after(150), first + 20);
}

TEST(EffortSplit, GoesWhereTheSameWorkLowersTheErrorMore) {
  EXPECT_TRUE((EffortSplit{.record_work = 10, .sample_work = 10, .record_error = 2, .sample_error = 1}.next_to_records()));
  EXPECT_FALSE((EffortSplit{.record_work = 30, .sample_work = 10, .record_error = 2, .sample_error = 1}.next_to_records()));
  EXPECT_FALSE(EffortSplit{}.next_to_records());
  // Records whose rays missed all light state no error.
  EXPECT_TRUE((EffortSplit{.record_work = 1, .sample_work = 10, .record_error = 0, .sample_error = 1}.next_to_records()));
}

// The same rays go over fewer records, of which there are as many as the accuracy's square is small.
TEST(CacheProgress, AtTheAccuracyOfAnEarlierStageRecordsHaveMorePasses) {
  const CacheProgress progress;
  for (const std::uint32_t spacing : {first, first + 7, first + 40}) {
    const std::uint32_t stage = spacing + 20;
    const double fewer = std::pow(progress.accuracy_at(spacing) / progress.accuracy_at(stage), 2.0f);
    EXPECT_NEAR(progress.passes_at(stage, spacing) / progress.passes_at(stage), fewer, 1e-4 * fewer);
  }
  EXPECT_EQ(progress.passes_at(first, 0), 1);  // in the overture records have what rays there are
}

TEST(CacheStanding, LoadedRecordsKeepASpacingOfTheirRefinement) {
  const CacheProgress progress, finer{.accuracy = 0.1f};
  CacheStanding saved, loaded;
  saved.enter(first + 30, first + 12);
  ByteWriter file;
  saved.write(file, progress.accuracy_at(saved.spacing()));
  ByteReader in(file.bytes, {});
  loaded.read(in);
  EXPECT_EQ(loaded.accuracy_wanted(progress), progress.accuracy_at(first + 12));
  EXPECT_EQ(loaded.spacing(), first + 12);
  EXPECT_EQ(loaded.accuracy_wanted(finer), finer.accuracy_at(first + 30));  // another one is asked for
  EXPECT_EQ(loaded.spacing(), first + 30);
}

TEST(EffortSplit, NoisyRecordsGetRaysBeforeNeighbours) {
  EXPECT_FALSE(EffortSplit{.record_error = 0.05}.next_to_neighbours(0.4f));
  EXPECT_TRUE(EffortSplit{.record_error = 0.05}.next_to_neighbours(0.8f));
  EXPECT_TRUE(EffortSplit{.record_error = 1e-3}.next_to_neighbours(0.4f));
}

TEST(CacheProgress, WithoutRefinementNothingChanges) {
  const CacheProgress progress{.accuracy = 0.1f, .refines = false};
  for (const std::uint32_t i : {0u, 3u, 5u, 1000u}) {
    EXPECT_EQ(progress.accuracy_at(i), 0.1f);
    EXPECT_EQ(progress.passes_at(i), 1);
    EXPECT_EQ(progress.rays_at(i, 256), 256);
  }
}

// Under a filter with negative parts a pixel is set anew by each sample, and one that is not finite leaves it as it was.
TEST(CachedLight, KeepsAPixelThatASampleSpoils) {
  CachedLight light({1, 1}, false, 0, true);
  Film film({1, 1});
  light.begin(0, 1);
  light.add(film, {0, 0}, Rgb(1), Rgb(2));
  EXPECT_EQ(film.mean().pixels[0].x, 3);
  light.begin(1, 1);
  light.add(film, {0, 0}, Rgb(infinity), Rgb(0));
  EXPECT_EQ(film.mean().pixels[0].x, 3);
  EXPECT_EQ(film.non_finite_count(), 1u);
}

// The scatter of the filter's signs is not that of the light: even light has none, and noise that signs part counts for more.
TEST(CachedLight, StatesTheErrorOfASignedPixel) {
  constexpr int samples = 256, seeds = 400;
  constexpr float negative = 0.2f;  // share of the weights
  for (const float noise : {0.0f, 3.0f}) {
    double sum = 0, squares = 0, stated = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      CachedLight light({1, 1}, true, 0, true);
      Film film({1, 1});
      Sampler sampler(SamplerKind::independent, seed, Stream::test, 0, 0);
      for (std::uint32_t i = 0; i < samples; ++i) {
        const float weight = i > 0 && sampler.get_1d() < negative ? -1.0f : 1.0f;
        light.begin(i, i + 1.0);
        light.add(film, {0, 0}, Rgb(weight * (1 + noise * (sampler.get_1d() - 0.5f))), Rgb(0), {}, weight);
      }
      const double mean = film.mean().pixels[0].x;
      sum += mean;
      squares += mean * mean;
      stated += square(light.standard_error().pixels[0].x);
    }
    if (noise == 0) {
      EXPECT_LT(stated, 1e-12);
      EXPECT_NEAR(sum / seeds, 1, 1e-6);
    } else {
      EXPECT_NEAR(stated / ((squares - sum * sum / seeds) * seeds / (seeds - 1)), 1, 0.25);
    }
  }
}

}  // namespace
}  // namespace etendue
