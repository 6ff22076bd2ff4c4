// The bias of images: against what methods declare of themselves, and against what an experiment predicts.
#include "experiments/log/json_line.h"
#include "experiments/report/declared.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/report_helpers.h"

#include <algorithm>

namespace etendue {
namespace {

using namespace report_test;

TEST(BiasPredictions, JudgeMeansOverSeedsByWhatIsDeclaredPlusFourStandardErrors) {
  RunLog log;
  log.manifests.push_back(manifest());
  log.references.push_back(reference("builtin:exact"));
  log.references.push_back(reference("builtin:rendered", 1e-6));
  log.references.push_back(reference("given.pbrt"));
  log.references.back().source = "given.exr";
  log.references.back().checks = "none: given by the experiment, its variance unknown";
  for (const char* scene : {"builtin:exact", "builtin:rendered", "given.pbrt"})
    add_cells(log, scene, {.integrator = "sound"}, 10);
  add_cells(log, "builtin:exact", {.integrator = "dark"}, 10);
  add_cells(log, "builtin:exact", {.integrator = "rare"}, 2);
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "dark") record.metrics["bias"] -= 0.03;
  for (CellRecord& cell : log.cells)
    if (cell.cell.integrator == "dark") cell.bias_bound = 0.02;

  const Table table = predictions_table(bias_predictions(arrange(log)));
  ASSERT_EQ(table.rows.size(), 2u);  // with a closed form and three seeds at least
  EXPECT_EQ(table.rows[0][column(table, "method")].raw, "sound");
  EXPECT_EQ(table.rows[0][column(table, "verdict")].raw, "confirmed");
  EXPECT_EQ(table.rows[1][column(table, "verdict")].raw, "refuted");
  for (CellRecord& cell : log.cells)
    if (cell.cell.integrator == "dark") cell.bias_bound = 0.03;
  EXPECT_EQ(bias_predictions(arrange(log)).rows[1].verdict, Verdict::confirmed);
  const Table references = references_table(arrange(log));
  EXPECT_EQ(references.rows[2][column(references, "mse_floor")].raw, "");
  EXPECT_TRUE(std::ranges::any_of(warnings_of(arrange(log)), [](const std::string& warning) {
    return warning.starts_with("given.pbrt: nobody knows the variance of the reference, given.exr");
  }));
}

TEST(BiasPredictions, RoundingIsNoBias) {
  RunLog log;
  log.references.push_back(reference("builtin:furnace"));
  add_cells(log, "builtin:furnace", {.integrator = "path"}, 3);
  for (CheckpointRecord& record : log.checkpoints) record.metrics["bias"] = -2.4e-8;  // of every seed
  EXPECT_EQ(bias_predictions(arrange(log)).rows.at(0).verdict, Verdict::confirmed);
  for (const std::string& warning : warnings_of(arrange(log)))
    EXPECT_EQ(warning.find("declared unbiased"), std::string::npos) << warning;
  for (CheckpointRecord& record : log.checkpoints) record.metrics["bias"] = -2.4e-5;
  EXPECT_EQ(bias_predictions(arrange(log)).rows.at(0).verdict, Verdict::refuted);
}

constexpr const char* bias_base =
    "scenes = [\"builtin:furnace\"]\n"
    "integrators = [\"path\"]\n"
    "metrics = [\"relmse\", \"bias\"]\n"
    "budget = { samples = 64 }\n"
    "[[predictions]]\n"
    "method = \"path\"\n"
    "expect = { bias = [-0.01, 0.01] }\n"
    "source = \"a paper\"\n";

std::string bias_with(const std::string& from, const std::string& to) { return replaced(bias_base, from, to); }

TEST(ImageBiasPredictions, AreReadAndKeptByTheLog) {
  const ExperimentConfig config = parse_experiment(bias_base, "x.toml");
  EXPECT_EQ(config.predictions.at(0).quantity, Prediction::Quantity::bias);
  EXPECT_EQ(config.predictions.at(0).expected, (Expected{-0.01, 0.01}));
  const StatedRecord record{config.predictions, config.regions};
  EXPECT_EQ(read_record<StatedRecord>(Json::parse(to_json_line(record))).predictions, config.predictions);
}

TEST(ImageBiasPredictions, SlipsAreErrorsAtTheirPlace) {
  expect_error(bias_with(", \"bias\"]", "]"), "x.toml:5:1", "bias is not among the metrics");
  expect_error(bias_with("source =", "metric = \"mse\"\nsource ="), "x.toml:8:1", "metric");
  expect_error(bias_with("source =", "region = \"left\"\nsource ="), "x.toml:8:1", "region");
  expect_error(bias_with("{ bias = [-0.01, 0.01] }", "{ bias = [0.01, -0.01] }"), "x.toml:7:19", "low <= high");
  expect_error(bias_with("{ bias = [-0.01, 0.01] }", "{ bias = [0, 1], ratio = 2 }"), "x.toml:7:27", "ratio");
}

TEST(ImageBiasPredictions, OneSeedTooFarOffRefutes) {
  RunLog log;
  log.references.push_back(reference("builtin:furnace"));
  add_cells(log, "builtin:furnace", {.integrator = "path"}, 3);
  log.stated.predictions = parse_experiment(bias_base, "x.toml").predictions;
  for (CheckpointRecord& record : log.checkpoints) record.metrics["bias"] = record.cell.seed == 2 ? -0.008 : 0.004;
  const JudgedPrediction kept = image_bias_predictions(arrange(log)).rows.at(0);
  EXPECT_EQ(kept.verdict, Verdict::confirmed);
  EXPECT_DOUBLE_EQ(kept.value.value(), -0.008);
  EXPECT_DOUBLE_EQ(kept.interval->high, 0.004);
  log.checkpoints.back().metrics.erase("bias");
  EXPECT_EQ(image_bias_predictions(arrange(log)).rows.at(0).verdict, Verdict::undecided);
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.seed == 3) record.metrics["bias"] = 0.02;
  const JudgedPrediction refuted = image_bias_predictions(arrange(log)).rows.at(0);
  EXPECT_EQ(refuted.verdict, Verdict::refuted);
  EXPECT_DOUBLE_EQ(refuted.value.value(), 0.02);
}

}  // namespace
}  // namespace etendue
