// Ratios from the experiment to the report.
#include "experiments/report/ratios.h"
#include "experiments/log/json_line.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/report_helpers.h"

#include <gtest/gtest.h>

#include <map>

namespace etendue {
namespace {

using namespace report_test;

constexpr const char* ratios_base =
    "scenes = [\"builtin:lambert-sphere\", \"builtin:furnace\"]\n"
    "integrators = [\"path\", { name = \"photon-map\", k = 20 }, { name = \"photon-map\", k = 40 }]\n"
    "budget = { samples = 64 }\n"
    "[[predictions]]\n"
    "method = \"photon-map\"\n"
    "over = \"path\"\n"
    "expect = { ratio = 1.5 }\n"
    "source = \"a paper\"\n";

std::string ratios_with(const std::string& from, const std::string& to) { return replaced(ratios_base, from, to); }

TEST(Ratios, ClaimIsReadInFullAndKeptByTheLog) {
  const ExperimentConfig config = parse_experiment(ratios_base, "x.toml");
  const Prediction claim = config.predictions.at(0);
  EXPECT_TRUE(claim.is_ratio());
  EXPECT_EQ(claim.method, "photon-map");
  EXPECT_EQ(claim.over, "path");
  EXPECT_EQ(claim.expected, (Expected{1.5, 1.5, "1.5"}));
  EXPECT_EQ(claim.source, "a paper");
  const StatedRecord record{config.predictions, config.regions};
  EXPECT_EQ(read_record<StatedRecord>(Json::parse(to_json_line(record))).predictions, config.predictions);
}

TEST(Ratios, DoNotChangeTheExperimentsHash) {
  EXPECT_EQ(parse_experiment(ratios_base, "x.toml").hash, parse_experiment(ratios_with("1.5", "2"), "x.toml").hash);
}

TEST(Ratios, SlipsAreErrorsAtTheirPlace) {
  expect_error(ratios_with("over = \"path\"\n", ""), "x.toml:6:12", "exponent");
  expect_error(ratios_with("\"photon-map\"\nover", "\"photon-mop\"\nover"), "x.toml:5:10", "photon-map k=20");
  expect_error(ratios_with("over = \"path\"", "over = \"photon-map\""), "x.toml:6:8", "selects 2");
  expect_error(ratios_with("source = \"a paper\"\n", ""), "x.toml:7:10", "without a source");
  expect_error(ratios_with("{ ratio = 1.5 }", "{ ratio = [2, 1] }"), "x.toml:7:20", "low <= high");
  expect_error(ratios_with("over =", "metric = \"mse\"\nover ="), "x.toml:6:1", "metric");
  expect_error(ratios_with("over =", "region = \"left\"\nover ="), "x.toml:6:10", "no [[regions]]");
  expect_error(ratios_with("over =", "scene = \"builtin:furnce\"\nover ="), "x.toml:6:9", "did you mean 'builtin:furnace'");
  expect_error(ratios_with("budget =", "metrics = [\"relmse\"]\nbudget ="), "x.toml:5:1", "mse is not among the metrics");
}

// Its errors are `factor` times 0.01, a little apart for each seed; each cell has one checkpoint.
void add_method(RunLog& log, const std::string& name, double factor, int seeds) {
  for (int seed = 1; seed <= seeds; ++seed) {
    add_cell(log, "room", {name, "sah", 0.1, 1, -1, 1}, static_cast<std::uint64_t>(seed));
    const double rmse = 0.01 * factor * (1 + 0.02 * std::sin(5.0 * seed));
    log.checkpoints.back().metrics["mse"] = rmse * rmse;
  }
}

RunLog three_methods(int seeds) {
  RunLog log;
  log.references.push_back(reference("room"));
  add_method(log, "cache metric=a records=9", 1, seeds);
  add_method(log, "cache metric=b records=9", 4, seeds);
  add_method(log, "cache metric=c records=9", 0.5, seeds);
  for (const auto& [method, expected] : {std::pair{"cache metric=b", 4.0}, {"cache metric=c", 1.5}})
    log.stated.predictions.push_back({.quantity = Prediction::Quantity::ratio,
                                      .method = method,
                                      .over = "cache metric=a",
                                      .scene = {},
                                      .region = {},
                                      .expected = Expected{expected, expected},
                                      .source = "a paper"});
  return log;
}

Predictions predictions_of(const RunLog& log) { return ratio_predictions(arrange(log)); }

double detail_of_ratio(const JudgedPrediction& row, const std::string& key) {
  return std::map(row.details.begin(), row.details.end()).at(key).order.value();
}

TEST(Ratios, LogOfKnownRatiosIsJudgedByThem) {
  const Predictions predictions = predictions_of(three_methods(10));
  ASSERT_EQ(predictions.rows.size(), 2u);
  const JudgedPrediction& first = predictions.rows[0];
  EXPECT_NEAR(first.value.value(), 4, 1e-9) << "seed by seed the errors go together";
  EXPECT_EQ(detail_of_ratio(first, "seeds"), 10);
  EXPECT_NEAR(detail_of_ratio(first, "rmse"), 0.04, 1e-3);
  EXPECT_LE(detail_of_ratio(first, "rmse_low"), detail_of_ratio(first, "rmse"));
  EXPECT_GE(detail_of_ratio(first, "rmse_high"), detail_of_ratio(first, "rmse"));
  EXPECT_EQ(predictions.rows[0].verdict, Verdict::confirmed);
  EXPECT_EQ(predictions.rows[1].verdict, Verdict::refuted) << "on the other side of 1";
  const std::string finding = predictions_finding(predictions);
  EXPECT_NE(finding.find("2 predictions: 1 confirmed, 1 refuted"), std::string::npos) << finding;
  EXPECT_NE(finding.find("of 1 pairs of methods 1 are in the order expected"), std::string::npos) << finding;
  const std::string table = to_markdown(predictions_table(predictions));
  EXPECT_NE(table.find("metric=b"), std::string::npos) << table;
  EXPECT_EQ(table.find("records=9"), std::string::npos) << "what all share does not tell them apart";
}

TEST(Ratios, ReferencesNoiseIsTakenAway) {
  RunLog log = three_methods(3);
  log.references[0].mse_floor = 2e-5;
  const JudgedPrediction row = predictions_of(log).rows.at(0);
  EXPECT_NEAR(detail_of_ratio(row, "rmse"), std::sqrt(square(0.04) - 2e-5), 1e-3);
  EXPECT_GT(row.value.value(), 4.3);
  log.references[0].mse_floor = 1;
  EXPECT_NE(predictions_of(log).rows.at(0).problem.find("noise"), std::string::npos);
}

// A resample in which both errors fall below the noise has no ratio, though the quotient of two negative numbers is one.
TEST(Ratios, ResamplesBelowTheReferencesNoiseHaveNone) {
  RunLog log = three_methods(8);
  const auto seeds_have = [&](const char* name, double few, double most) {
    for (CheckpointRecord& record : log.checkpoints)
      if (record.cell.integrator == name) record.metrics["mse"] = record.cell.seed <= 2 ? few : most;
  };
  log.references[0].mse_floor = 1e-3;
  seeds_have("cache metric=a records=9", 5e-3, 0.9e-3);  // 4e-3 twice and -1e-4 six times
  seeds_have("cache metric=b records=9", 21e-3,
             0.1e-3);  // 2e-2 twice and -9e-4 six times: 9 times as much where no seed is above
  const JudgedPrediction row = predictions_of(log).rows.at(0);
  ASSERT_EQ(row.problem, "");
  ASSERT_TRUE(row.interval);
  EXPECT_LE(row.interval->high, std::sqrt(5.0) + 1e-9) << "3 is the root of 9e-4 over 1e-4";
}

TEST(Ratios, FewSeedsHaveNoInterval) {
  const JudgedPrediction row = predictions_of(three_methods(2)).rows.at(0);
  EXPECT_FALSE(row.interval);
  EXPECT_EQ(row.verdict, Verdict::undecided);
}

// In a time that ends them runs get farther by the better structure, so that each has its own ratio.
TEST(Ratios, AreOfOneStructureEach) {
  RunLog log;
  log.manifests.push_back(manifest());
  log.references.push_back(reference("room"));
  for (const char* accel : {"median", "sah"})
    for (const char* method : {"path", "cache"})
      for (int seed = 1; seed <= 3; ++seed) {
        add_cell(log, "room", {method, accel, 0.1, 1, -1, 1}, static_cast<std::uint64_t>(seed));
        const bool is_twice = std::string(method) == "cache" && std::string(accel) == "sah";
        log.checkpoints.back().metrics["mse"] = is_twice ? 0.04 : 0.01;
      }
  log.stated.predictions = {{.quantity = Prediction::Quantity::ratio,
                             .method = "cache",
                             .over = "path",
                             .scene = {},
                             .region = {},
                             .expected = Expected{2, 2},
                             .source = "a paper"}};
  EXPECT_EQ(ratio_predictions(arrange(log)).rows.size(), 1u) << "iterations ended them";
  log.manifests[0].budget_s = 1;
  const auto rows = ratio_predictions(arrange(log)).rows;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(*rows[0].value, 1, 1e-9);
  EXPECT_NEAR(*rows[1].value, 2, 1e-9);
  EXPECT_EQ(rows[1].structure, "sah");
}

}  // namespace
}  // namespace etendue
