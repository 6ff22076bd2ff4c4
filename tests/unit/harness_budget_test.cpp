// The budget and the one loop that spends it.
#include "experiments/config/budget.h"
#include "experiments/run/run_cell.h"
#include "framework/core/error.h"
#include "framework/image/flip.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

// Iterations at which a walk of equal steps takes its checkpoints.
std::vector<std::uint64_t> checkpoints(const Budget& budget, double iteration_s) {
  BudgetSchedule schedule(budget);
  std::vector<std::uint64_t> at;
  for (std::uint64_t i = 1;; ++i) {
    const double time = iteration_s * static_cast<double>(i);
    const bool last = schedule.finished(i, time, iteration_s);
    if (schedule.checkpoint_due(i, time) || last) at.push_back(i);
    if (last) return at;
  }
}

Budget samples(std::uint64_t count, const char* ladder = "log") {
  Budget budget;
  budget.samples = count;
  budget.checkpoints = CheckpointLadder::parse(ladder);
  return budget;
}

Budget seconds(double time, const char* ladder = "log") {
  Budget budget;
  budget.time_s = time;
  budget.checkpoints = CheckpointLadder::parse(ladder);
  return budget;
}

using List = std::vector<std::uint64_t>;

TEST(BudgetSchedule, SampleLaddersEndAtTheBudget) {
  EXPECT_EQ(checkpoints(samples(16), 1), (List{1, 2, 4, 8, 16}));
  EXPECT_EQ(checkpoints(samples(100), 1), (List{1, 2, 4, 7, 13, 25, 50, 100}));
  EXPECT_EQ(checkpoints(samples(10, "linear:5"), 1), (List{1, 2, 4, 6, 8, 10}));
  EXPECT_EQ(checkpoints(samples(8, "sqrt2"), 1), (List{1, 2, 3, 4, 6, 8}));
  EXPECT_EQ(checkpoints(samples(1), 1), (List{1}));
  EXPECT_EQ(checkpoints(samples(256, "quarters:3"), 1), (List{1, 16, 64, 256}));
  EXPECT_EQ(checkpoints(samples(256, "quarters:1"), 1), (List{1, 256}));
}

TEST(BudgetSchedule, TimeLadderIsLogarithmicAndEndsBeforeOverrunning) {
  // Rungs at 10, 5, 2.5, ... s; iterations of 0.3 s: 33 of them take 9.9 s.
  EXPECT_EQ(checkpoints(seconds(10), 0.3), (List{1, 2, 3, 5, 9, 17, 33}));
}

TEST(BudgetSchedule, FirstIterationRunsWhateverItTakes) { EXPECT_EQ(checkpoints(seconds(1), 60), (List{1})); }

TEST(BudgetSchedule, OneDelayedIterationDoesNotEndTheCell) {
  BudgetSchedule schedule(seconds(10));
  EXPECT_FALSE(schedule.finished(1, 1, 1));
  EXPECT_FALSE(schedule.finished(2, 2, 1));
  EXPECT_FALSE(schedule.finished(3, 7, 5));
  EXPECT_FALSE(schedule.finished(4, 8, 1));
  EXPECT_TRUE(schedule.finished(5, 9.5, 1.5));
}

TEST(BudgetSchedule, FirstLimitReachedEnds) {
  Budget budget = seconds(100);
  budget.samples = 4;
  EXPECT_EQ(checkpoints(budget, 1).back(), 4u);
  budget.samples = 1000;
  EXPECT_EQ(checkpoints(budget, 1).back(), 100u);
}

TEST(CheckpointLadder, BadTextIsAnError) {
  for (const char* bad : {"", "logg", "linear:", "linear:0", "linear:x", "linear:5x", "quarters:0", "quarters:11"})
    EXPECT_THROW(CheckpointLadder::parse(bad), Error) << bad;
}

class RunCell : public ::testing::Test {
 protected:
  CellResult run(const Budget& budget, const Image* reference = nullptr, int threads = 2) {
    return run_cell({scene_, needs_, accel_, method_, 3, {8, 8}, budget, threads, reference, {"relmse", "bias"}});
  }

  Scene scene_ = load_scene("builtin:lambert-sphere");
  SceneNeeds needs_ = scene_needs(scene_);
  Method accel_{"binned-sah", {}, {}};
  Method method_{"path", {}, {}};
};

TEST_F(RunCell, CheckpointsHoldWhatTheyMust) {
  const CellResult result = run(samples(4));
  ASSERT_EQ(result.checkpoints.size(), 3u);
  double before = 0;
  for (const CheckpointRecord& checkpoint : result.checkpoints) {
    EXPECT_GT(checkpoint.time_s, before);
    before = checkpoint.time_s;
    double phases = 0;
    for (const auto& [phase, time] : checkpoint.phases_s) phases += time;
    EXPECT_NEAR(phases, checkpoint.time_s, 1e-6 + 0.02 * checkpoint.time_s);
    EXPECT_TRUE(checkpoint.phases_s.contains("build"));
    EXPECT_TRUE(checkpoint.phases_s.contains("other"));
    EXPECT_GT(checkpoint.peak_memory_bytes, 0u);
    EXPECT_GE(checkpoint.counters.at("rays"), 64 * checkpoint.iterations);
    EXPECT_TRUE(checkpoint.metrics.empty());
  }
  EXPECT_EQ(result.checkpoints.back().iterations, 4u);
  EXPECT_EQ(result.expectation.bias, Bias::unbiased);
}

// The pilot of progressive photon mapping emits photons, builds a map and gathers.
TEST_F(RunCell, PhasesWithinPhasesCountOnce) {
  for (const char* method : {"appm", "photon-cache"}) {
    method_ = {method, {}, {}};
    const CheckpointRecord end = run(samples(1)).checkpoints.back();
    double phases = 0;
    for (const auto& [phase, time] : end.phases_s) phases += time;
    EXPECT_NEAR(phases, end.time_s, 1e-6 + 1e-3 * end.time_s) << method;
    EXPECT_GT(end.phases_s.at("pilot"), 0) << method;
    EXPECT_GT(end.phases_s.at("emit"), 0) << method;
  }
}

TEST_F(RunCell, ImageDependsOnTheSeedAndNotOnTheThreads) {
  const CellResult one = run(samples(4), nullptr, 1), three = run(samples(4), nullptr, 3);
  EXPECT_EQ(one.image_hash, three.image_hash);
  EXPECT_EQ(one.checkpoints.back().counters, three.checkpoints.back().counters);
}

TEST_F(RunCell, MetricsAreAgainstTheReference) {
  const CellResult result = run(samples(4));
  const CellResult again = run(samples(4), &result.image);
  EXPECT_EQ(again.checkpoints.back().metrics.at("relmse"), 0);
  EXPECT_GT(again.checkpoints.front().metrics.at("relmse"), 0);
}

// A region's share of a map of the whole image: what lies beside it is seen, too.
TEST_F(RunCell, FlipIsMeasuredWhereItIsAskedFor) {
  const Image reference = run(samples(64)).image;
  EXPECT_FALSE(run(samples(1), &reference).checkpoints.back().metrics.contains("flip"));
  const Budget budget = samples(1);
  CellTask task{scene_, needs_, accel_, method_, 3, {8, 8}, budget, 1, &reference, {"relmse", "flip"}};
  task.regions = {{"corner", {0, 1, 8}}};
  const CellResult result = run_cell(task);
  const CheckpointRecord& last = result.checkpoints.back();
  const std::vector<double> errors = flip_errors(result.image, reference);
  EXPECT_DOUBLE_EQ(last.metrics.at("flip"), mean_of(errors));
  EXPECT_GT(last.metrics.at("flip"), 0);
  EXPECT_DOUBLE_EQ(last.regions.at("corner").at("flip"), (errors[0] + errors[1] + errors[8]) / 3);
  EXPECT_GT(last.regions.at("corner").at("relmse"), 0);
}

TEST_F(RunCell, ErrorTargetEndsTheCellEarly) {
  const Image reference = run(samples(256)).image;
  Budget budget = samples(4096);
  budget.error = 2 * relmse(run(samples(16)).image, reference);
  const CellResult result = run(budget, &reference);
  EXPECT_TRUE(result.reached_error);
  EXPECT_LT(result.checkpoints.back().iterations, 64u);
  EXPECT_LE(result.checkpoints.back().metrics.at("relmse"), *budget.error);
  budget.error = 1e-12;
  budget.samples = 4;
  EXPECT_FALSE(run(budget, &reference).reached_error);
}

TEST_F(RunCell, StoppedIsOnlyWhatWasNotDone) {
  const auto stopped = [&](const Budget& budget, const Image* reference = nullptr) {
    CellTask task{scene_, needs_, accel_, method_, 3, {8, 8}, budget, 1, reference};
    task.stop = [] { return true; };
    return run_cell(task).stopped;
  };
  EXPECT_TRUE(stopped(samples(2)));
  EXPECT_FALSE(stopped(samples(1))) << "the budget's last iteration";
  const Image reference = run(samples(1)).image;
  Budget budget = samples(4);
  budget.error = 1e6;
  EXPECT_FALSE(stopped(budget, &reference)) << "the error was reached";
  EXPECT_FALSE(run(samples(2)).stopped);
}

TEST_F(RunCell, TimeBudgetHolds) {
  const CellResult result = run(seconds(0.2));
  EXPECT_LE(result.checkpoints.back().time_s, 0.25);
  EXPECT_GT(result.checkpoints.back().iterations, 1u);
}

}  // namespace
}  // namespace etendue
