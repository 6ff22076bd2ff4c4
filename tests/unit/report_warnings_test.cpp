// Warnings of the report, by the log that it is about.
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "tests/unit/report_helpers.h"

#include <algorithm>

namespace etendue {
namespace {

using namespace report_test;

bool warns(const RunLog& log, const std::string& part) {
  const auto warnings = warnings_of(arrange(log));
  return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& w) { return w.find(part) != std::string::npos; });
}

TEST(Warnings, NoisyReferenceIsFlaggedAboveOnePercent) {
  RunLog log = small_log();
  const double least = 0.5 * 0.1 * std::pow(128, -2.0 / 3);
  log.references[0].mse_floor = 0.005 * least;
  EXPECT_FALSE(warns(log, "own variance"));
  log.references[0].mse_floor = 0.02 * least;
  EXPECT_TRUE(warns(log, "own variance"));
}

TEST(Warnings, NoiseThatNothingIsHeldAgainstIsFlagged) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints) record.metrics.erase("mse");
  EXPECT_FALSE(warns(log, "no mse was logged"));
  log.references[0].mse_floor = 1e-6;
  EXPECT_TRUE(warns(log, "builtin:room: the reference has noise of its own, and no mse was logged"));
  EXPECT_FALSE(warns(small_log(), "no mse was logged"));
}

TEST(Warnings, WhatTheReadersFoundIsSaid) {
  RunLog log = small_log();
  const std::string scene = log.references[0].scene;
  for (int i = 0; i < 12; ++i) log.references[0].warnings.push_back("s.pbrt:" + std::to_string(i + 1) + ":1: skipped");
  log.references[0].warnings.push_back("s.pbrt:20:1: 'a.exr' holds NaN or infinity in 3 texels");
  EXPECT_TRUE(warns(log, scene + ": s.pbrt:20:1: 'a.exr' holds NaN or infinity in 3 texels")) << "before what is less";
  EXPECT_TRUE(warns(log, "s.pbrt:9:1: skipped"));
  EXPECT_FALSE(warns(log, "s.pbrt:10:1: skipped"));
  EXPECT_TRUE(warns(log, scene + ": 3 more warnings of its reader stand in the log."));
}

TEST(Warnings, OneSeedFailuresAndNonFiniteSamplesAreSaid) {
  RunLog log;
  log.references.push_back(reference("room"));
  add_cells(log, "room", {}, 1);
  EXPECT_TRUE(warns(log, "One seed"));
  log.checkpoints.back().non_finite = 3;
  EXPECT_TRUE(warns(log, "3 non-finite samples"));
  log.cells.back().non_finite_at = {{4, 5, 6}, {7, 8, 9}};
  EXPECT_TRUE(warns(log, "seed 1 pixel (4, 5) iteration 6;"));
  EXPECT_TRUE(warns(log, "pixel (7, 8) iteration 9."));
  EXPECT_FALSE(warns(small_log(), "One seed"));
  EXPECT_FALSE(warns(small_log(), "non-finite"));
}

TEST(Warnings, BiasOfAnUnbiasedMethodIsFlagged) {
  RunLog log = small_log();
  EXPECT_FALSE(warns(log, "declared unbiased"));
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "path") record.metrics["bias"] = 0.05 + 0.001 * static_cast<double>(record.cell.seed);
  EXPECT_TRUE(warns(log, "declared unbiased"));
}

// The reference that all seeds are compared with has a mean that is as uncertain as theirs if its variance is as large.
TEST(Warnings, BiasWithinTheReferencesNoiseIsNotFlagged) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "path") record.metrics["bias"] = 0.003 + 0.001 * static_cast<double>(record.cell.seed);
  EXPECT_TRUE(warns(log, "declared unbiased"));
  log.references[0].mse_floor = 0.9 * 0.5 / 128;  // of the mean squared error of a seed
  EXPECT_FALSE(warns(log, "declared unbiased"));
  log.references[0].mse_floor = 0;
  log.references[0].checks = "none: given by the experiment, its variance unknown";
  EXPECT_FALSE(warns(log, "declared unbiased")) << "no bias is judged by it, as the report says";
}

TEST(Warnings, StructuresThatChangeTheImageAreFlagged) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"path", "median", 0.2, 1, -1}, 3);
  for (CellRecord& cell : log.cells) cell.image_hash = "h" + std::to_string(cell.cell.seed) + cell.cell.integrator;
  EXPECT_FALSE(warns(log, "differ between structures"));
  log.cells.back().image_hash = "other";
  EXPECT_TRUE(warns(log, "differ between structures"));
}

TEST(Warnings, SlowConvergenceIsFlaggedWithTenSeeds) {
  RunLog log;
  log.references.push_back(reference("room"));
  add_cells(log, "room", {"path", "sah", 0.1, 1, -0.4}, 10);
  EXPECT_FALSE(warns(log, "more slowly"));
  for (CellRecord& cell : log.cells) cell.mse_exponent = -1;
  EXPECT_TRUE(warns(log, "more slowly"));
}

TEST(Warnings, SeedsOfDifferentBudgetsAreTold) {
  const auto told = [](const RunLog& log) {
    return std::ranges::any_of(warnings_of(arrange(log)), [](const std::string& warning) {
      return warning.find("different budgets") != std::string::npos;
    });
  };
  const auto log_of = [](std::initializer_list<std::pair<int, const char*>> runs) {  // checkpoints, manifest
    RunLog log;
    log.manifests = {manifest(), manifest()};
    log.manifests[1].id = "n";
    log.manifests[1].experiment_hash = "other";
    std::uint64_t seed = 0;
    for (const auto& [checkpoints, manifest] : runs) {
      add_cell(log, "room", {.checkpoints = checkpoints}, ++seed);
      for (CheckpointRecord& record : log.checkpoints)
        if (record.cell.seed == seed) record.manifest = manifest;
    }
    return log;
  };
  EXPECT_FALSE(told(log_of({{4, "m"}, {4, "n"}}))) << "more seeds of one budget";
  EXPECT_TRUE(told(log_of({{4, "m"}, {6, "n"}, {6, "n"}})));
  EXPECT_FALSE(told(log_of({{4, "m"}, {6, "m"}, {5, "n"}, {7, "n"}}))) << "an error ends each seed elsewhere";
}

TEST(Warnings, TimesOfDifferentInstructionSetsAreTold) {
  RunLog log = small_log();
  log.manifests[0].isa = "AVX2";
  const auto told = [](const RunLog& of) {
    return std::ranges::any_of(warnings_of(arrange(of)), [](const std::string& warning) {
      return warning.starts_with("2 different machines, instruction");
    });
  };
  log.manifests.push_back(log.manifests[0]);
  EXPECT_FALSE(told(log));
  log.manifests[1].isa = "AVX-512";
  EXPECT_TRUE(told(log));
  log.manifests[1].isa = log.manifests[0].isa;
  log.manifests[1].cpu_family = 26;
  EXPECT_TRUE(told(log)) << "under the same name";
}

// Structures of one method lead together, and what leads for a moment is left out.
TEST(Findings, LeadsOverTimeLastForHalfOfTheirBeginning) {
  RunLog log;
  add_cells(log, "builtin:room", {"path", "sah", 0.1, 1, -0.5}, 3);
  add_cells(log, "builtin:room", {"path", "lbvh", 0.1, 0.9, -0.5}, 3);
  add_cells(log, "builtin:room", {"sppm", "sah", 0.1, 2, -1}, 3);
  const Conclusions conclusions = conclude(arrange(log));
  std::string text;
  for (const Finding& finding : conclusions.scenes.at(0).findings)
    if (finding.topic == "Over time") text = finding.text;
  EXPECT_EQ(text.find("Least error: path from"), 0u) << text;
  EXPECT_EQ(text.find("path", text.find("path") + 1), std::string::npos) << text;
  EXPECT_NE(text.find(", then sppm from"), std::string::npos) << text;
}

// A scene whose cells all failed is not left out of the findings.
TEST(Findings, SayWhyNoCellOfASceneFinished) {
  RunLog log = small_log();
  add_failure(log, {"builtin:hall", "sah", "path", 1}, "no reference of builtin:hall");
  const Conclusions conclusions = conclude(arrange(log));
  ASSERT_EQ(conclusions.scenes.size(), 2u);
  EXPECT_EQ(conclusions.scenes[1].scene, "builtin:hall");
  EXPECT_EQ(conclusions.scenes[1].findings.at(0).text, "no reference of builtin:hall");
}

}  // namespace
}  // namespace etendue
