#include "experiments/report/declared.h"
#include "experiments/report/rates.h"
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "tests/unit/report_helpers.h"

#include <algorithm>
#include <sstream>

namespace etendue {
namespace {

using namespace report_test;

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) result.push_back(line);
  return result;
}

TEST(ReportData, CommonTimeIsTheLatestThatAllReached) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"slow", "sah", 0.05, 1, -1, 7}, 3);  // ends at 3.2 s
  const ReportData data = arrange(log);
  ASSERT_EQ(data.scenes.size(), 1u);
  EXPECT_DOUBLE_EQ(data.scenes[0].common_time_s, 3.2);
  EXPECT_EQ(data.main_metric(), "relmse");
  EXPECT_TRUE(data.is_signed("bias"));
  EXPECT_FALSE(data.is_signed("mse"));
}

// A cell stops before an iteration that would overrun its time; until then it has the image that it has.
TEST(ReportData, CommonTimeIsTheBudgetThatEndedTheCells) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"slow", "sah", 3.5, 1, -1, 2}, 3);       // 3.5 s and 7 s
  add_cells(log, "builtin:room", {"too-slow", "sah", 14, 0.1, -1, 1}, 3);  // its first iteration overran
  log.manifests.front().budget_s = 13;
  const ReportData data = arrange(log);
  EXPECT_DOUBLE_EQ(data.scenes[0].common_time_s, 13);
  const auto& configurations = data.scenes[0].configurations;
  EXPECT_EQ(values_at(configurations[2], "relmse", 13), final_values(configurations[2], "relmse"));
  EXPECT_EQ(estimate_at(configurations[2], "relmse", 13.5), std::nullopt);
  EXPECT_EQ(estimate_at(configurations[3], "relmse", 13), std::nullopt);
}

TEST(ReportData, TheTargetIsReachedByHalfOfAllConfigurations) {
  RunLog log = small_log();
  log.manifests.front().budget_s = 13;
  add_cells(log, "builtin:room", {"too-slow", "sah", 14, 0.1, -1, 1}, 3);
  EXPECT_EQ(arrange(log).scenes[0].target_error, 0.01) << "path and sppm, of three, are below";
  for (const char* name : {"slower", "slowest"}) add_cells(log, "builtin:room", {name, "sah", 15, 0.1, -1, 1}, 3);
  EXPECT_EQ(arrange(log).scenes[0].target_error, 0) << "three of five have no image by then";
}

TEST(ReportData, AnImageWithoutAValueHoldsNone) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"overflows", "sah", 3.5, 1, -1, 2}, 3);
  for (CheckpointRecord& checkpoint : log.checkpoints)
    if (checkpoint.cell.integrator == "overflows" && checkpoint.iterations == 2) checkpoint.metrics.erase("relmse");
  log.manifests.front().budget_s = 13;
  const ReportData data = arrange(log);
  EXPECT_DOUBLE_EQ(data.scenes[0].common_time_s, 3.5);
  const Configuration& overflows = data.scenes[0].configurations[2];
  EXPECT_TRUE(values_at(overflows, "relmse", 13).empty());
  EXPECT_EQ(values_at(overflows, "mse", 13).size(), 3u);
}

TEST(ReportData, AggregateAveragesSeedsInLogarithmsAtTheirCheckpoints) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1}, 4);
  const ReportData data = arrange(log);
  const Configuration& path = data.scenes[0].configurations[0];
  const auto points = aggregate(path, "relmse", Abscissa::iterations, false);
  ASSERT_EQ(points.size(), 8u);
  double log_factor = 0;
  for (int seed = 1; seed <= 4; ++seed) log_factor += 0.1 * std::sin(7.0 * seed) / 4;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].x, std::pow(2.0, i));
    EXPECT_NEAR(points[i].y.centre, std::exp(log_factor) / points[i].x, 1e-12);
    EXPECT_EQ(points[i].y.spread, Spread::t95);
  }
}

TEST(ReportData, SeedsAreNotReadOutsideWhatTheyMeasured) {
  RunLog log;
  add_cell(log, "room", {"path", "sah", 0.1, 1, -1}, 1);
  add_cell(log, "room", {"path", "sah", 0.2, 1, -1}, 2);  // twice as slow: 0.2 s to 25.6 s
  const ReportData data = arrange(log);
  const auto points = aggregate(data.scenes[0].configurations[0], "relmse", Abscissa::time, false);
  ASSERT_GE(points.size(), 2u);
  EXPECT_NEAR(points.front().x, 0.2, 1e-12);
  EXPECT_NEAR(points.back().x, 12.8, 1e-12);
}

TEST(ReportData, OneCheckpointGivesOnePoint) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1, 1}, 3);
  const ReportData data = arrange(log);
  EXPECT_EQ(aggregate(data.scenes[0].configurations[0], "relmse", Abscissa::time, false).size(), 1u);
  EXPECT_FALSE(measured_rate(data.scenes[0].configurations[0], nullptr));
}

TEST(ReportData, MeasuredRateIsTheDeclaredOne) {
  const RunLog log = small_log();
  const ReportData data = arrange(log);
  const auto path = measured_rate(data.scenes[0].configurations[0], data.scenes[0].reference);
  const auto sppm = measured_rate(data.scenes[0].configurations[1], data.scenes[0].reference);
  ASSERT_TRUE(path && sppm);
  EXPECT_NEAR(path->fit.exponent, -1, 1e-9);
  EXPECT_NEAR(sppm->fit.exponent, -2.0 / 3, 1e-9);
  EXPECT_EQ(path->metric, "mse");
  EXPECT_EQ(path->fit.from, 16);  // the later half of 1 to 128
  EXPECT_EQ(path->fit.to, 128);
}

// The points that are left would give another slope: a mean that is not above the reference's own noise has no logarithm.
TEST(ReportData, NoRateIsMeasuredBelowTheReferencesNoise) {
  RunLog log = small_log();
  log.references[0].mse_floor = 0.005;  // the MSE of path is 0.008 after 64 iterations and 0.004 after 128
  const ReportData data = arrange(log);
  EXPECT_FALSE(measured_rate(data.scenes[0].configurations[0], data.scenes[0].reference));
  EXPECT_EQ(final_table(data).rows[1][column(final_table(data), "measured_mse_exponent")].raw, "");
}

// Where no mse was logged, the exponent is that of relmse: its part of the noise is taken off, and where nobody knows that part
// there is no exponent, for the noise would flatten the curve.
TEST(ReportData, RateOfRelativeErrorsIsFreeOfTheReferencesNoise) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints) {
    record.metrics.erase("mse");
    record.metrics["relmse"] += 0.02;
  }
  log.references[0].mse_floor = log.references[0].relmse_floor = 0.02;
  const ReportData data = arrange(log);
  const auto path = measured_rate(data.scenes[0].configurations[0], data.scenes[0].reference);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->metric, "relmse");
  EXPECT_NEAR(path->fit.exponent, -1, 1e-6);
  log.references[0].relmse_floor = 0;
  EXPECT_FALSE(measured_rate(data.scenes[0].configurations[0], data.scenes[0].reference));
}

// The curves are the same, and the better one ends sooner.
TEST(ReportData, NobodyLeadsWhereOthersHaveEnded) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1}, 1);        // until 12.8 s
  add_cells(log, "room", {"slow", "sah", 0.1, 1, -0.9, 12}, 1);  // until 204.8 s
  const auto rulers = lead_intervals(arrange(log).scenes[0], "relmse");
  ASSERT_EQ(rulers.size(), 1u);
  EXPECT_EQ(rulers[0].configuration, 0u);
}

TEST(ReportData, LeadPassesWhereTheCurvesCross) {
  RunLog log;  // 1/N against 0.25 N^(-1/2): they cross at N = 16, t = 1.6 s
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1}, 1);
  add_cells(log, "room", {"cache", "sah", 0.1, 0.25, -0.5}, 1);
  const ReportData data = arrange(log);
  const auto rulers = lead_intervals(data.scenes[0], "relmse");
  ASSERT_EQ(rulers.size(), 2u);
  EXPECT_EQ(data.scenes[0].configurations[rulers[0].configuration].integrator, "cache");
  EXPECT_EQ(data.scenes[0].configurations[rulers[1].configuration].integrator, "path");
  EXPECT_GT(rulers[1].begin_s, 1.5);
  EXPECT_LT(rulers[1].begin_s, 3.3);
}

TEST(ReportData, CheckpointsWithoutTheMetricArePassedOver) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1}, 1);
  for (CheckpointRecord& checkpoint : log.checkpoints)
    if (checkpoint.iterations == 4) checkpoint.metrics.erase("relmse");
  const SceneData scene = arrange(log).scenes[0];
  const std::vector<double> at_once = values_at(scene.configurations[0], "relmse", 0.1);
  ASSERT_EQ(values_at(scene.configurations[0], "relmse", 0.45).size(), 1u);
  EXPECT_NEAR(values_at(scene.configurations[0], "relmse", 0.45)[0] / at_once[0], 0.25, 1e-9);
}

// Nobody has seen an image of one and a half iterations.
TEST(ReportData, ATimeHasTheImageOfItsLastWholeIteration) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1, -1}, 1);
  add_cells(log, "room", {"slow", "sah", 4, 1, -13, 2}, 1);  // far ahead of path after two iterations, at 8 s
  const SceneData scene = arrange(log).scenes[0];
  const Configuration &path = scene.configurations[0], &slow = scene.configurations[1];
  EXPECT_EQ(values_at(slow, "relmse", 7.9), values_at(slow, "relmse", 4));
  EXPECT_NEAR(values_at(path, "relmse", 0.59)[0] / values_at(path, "relmse", 0.1)[0], 0.2, 1e-9);  // between 4 and 8
  EXPECT_EQ(values_at(path, "relmse", 0.09).size(), 0u);
  EXPECT_DOUBLE_EQ(arrival_of(slow, "relmse", 0.5)->median.time, 8);
  EXPECT_NEAR(arrival_of(path, "relmse", values_at(path, "relmse", 0.1)[0] / 4.5)->median.time, 0.5, 1e-9);
  const auto leads = lead_intervals(scene, "relmse");
  ASSERT_EQ(leads.size(), 2u);
  EXPECT_DOUBLE_EQ(leads[1].begin_s, 8);
}

TEST(ReportData, FailedCellsAreKeptApart) {
  RunLog log = small_log();
  add_failure(log, {"builtin:room", "sah", "path", 4}, "out of memory");
  const ReportData data = arrange(log);
  EXPECT_EQ(data.failed, 1u);
  EXPECT_EQ(data.done, 6u);
  EXPECT_EQ(data.scenes[0].configurations[0].replicates.size(), 3u);
  const Table table = failures_table(data);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][4].text, "out of memory");
}

TEST(Tables, FinalRowsAreOrderedByErrorAtEqualTime) {
  const RunLog log = small_log();
  const Table table = final_table(arrange(log));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0][1].raw, "sppm");  // 0.1 * 128^(-2/3) < 1/128
  EXPECT_EQ(table.rows[0][column(table, "seeds")].raw, "3");
  EXPECT_EQ(table.rows[0][column(table, "relmse_at_common_time_interval")].raw, "t95");
  EXPECT_EQ(table.rows[0][column(table, "iterations_median")].raw, "128");
  EXPECT_EQ(table.rows[0][column(table, "declared_bias")].raw, "consistent");
  EXPECT_NEAR(std::stod(table.rows[0][column(table, "measured_mse_exponent")].raw), -2.0 / 3, 1e-9);
  const double relmse = std::stod(table.rows[1][column(table, "relmse_median")].raw);
  EXPECT_NEAR(1 / (relmse * 12.8), *table.rows[1][column(table, "efficiency_per_s")].order, 1e-9);
}

TEST(Tables, ColumnsOfFiguresSort) {
  for (const Table& table : report_tables(arrange(small_log()))) EXPECT_TRUE(columns_of_figures_sort(table));
}

TEST(Tables, WhatNeverArrivesIsCensoredNotDropped) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"noisy", "sah", 0.1, 50, -1}, 3);
  const Table table = final_table(arrange(log));
  ASSERT_EQ(table.rows.size(), 3u);
  const auto& noisy = table.rows[2];
  EXPECT_EQ(noisy[1].raw, "noisy");
  EXPECT_EQ(noisy[column(table, "time_to_target_censoring")].raw, "right");
  EXPECT_EQ(noisy[column(table, "time_to_target_arrived")].raw, "0");
  const std::string text = noisy[column(table, "target_relmse") + 1].text;
  EXPECT_EQ(text.substr(0, 2), "> ") << text;
  EXPECT_GT(*noisy[column(table, "target_relmse") + 1].order, *table.rows[1][column(table, "target_relmse") + 1].order);
  EXPECT_EQ(noisy[column(table, "time_to_target_p95_censoring")].raw, "right");
  EXPECT_EQ(table.rows[0][column(table, "time_to_target_p95_censoring")].raw, "none");
}

TEST(Tables, MethodsAreComparedWithTheFirstByRanks) {
  const RunLog few = small_log();
  const Table three = final_table(arrange(few));
  EXPECT_EQ(three.rows[0][column(three, "rank_p")].raw, "") << "it is the first";
  EXPECT_NEAR(*three.rows[1][column(three, "rank_p")].order, 0.1, 1e-9);
  EXPECT_EQ(three.rows[1][column(three, "rank_p") - 1].text, "0.1 ‡") << "of three seeds nothing can be said";
  RunLog many;
  add_cells(many, "builtin:room", {"path", "sah", 0.1, 1, -1}, 9);
  add_cells(many, "builtin:room", {"sppm", "sah", 0.1, 0.1, -2.0 / 3, 8, "consistent"}, 9);
  const Table nine = final_table(arrange(many));
  EXPECT_LT(*nine.rows[1][column(nine, "rank_p")].order, 1e-4);
  EXPECT_EQ(nine.rows[1][column(nine, "rank_p") - 1].text.find("‡"), std::string::npos);
}

TEST(Tables, MarkdownColumnsAlignInATerminal) {
  const RunLog log = small_log();
  const ReportData data = arrange(log);
  for (const Table& table : report_tables(data)) {
    std::size_t width = 0;
    for (const std::string& line : lines(to_markdown(table))) {
      if (!line.starts_with('|')) {
        width = 0;
        continue;
      }
      if (width > 0) {
        EXPECT_EQ(display_width(line), width) << table.name << "\n" << line;
      }
      width = display_width(line);
      EXPECT_LE(width, 200u) << table.name;
    }
  }
}

TEST(Tables, CsvRowsHaveAsManyFieldsAsTheHead) {
  const RunLog log = small_log();
  const ReportData data = arrange(log);
  for (const Table& table : report_tables(data)) {
    const auto rows = lines(to_csv(table));
    for (const std::string& row : rows) {
      bool quoted = false;
      std::size_t fields = 1;
      for (const char c : row) {
        quoted = quoted != (c == '"');
        fields += c == ',' && !quoted;
      }
      EXPECT_EQ(fields, 1 + static_cast<std::size_t>(std::count(rows[0].begin(), rows[0].end(), ','))) << table.name << "\n"
                                                                                                       << row;
    }
  }
}

TEST(Tables, CsvKeepsAllDigits) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1, 1.0 / 3, -1}, 1);
  const Table table = final_table(arrange(log));
  const double raw = std::stod(table.rows[0][column(table, "relmse_median")].raw);
  EXPECT_EQ(raw, log.checkpoints.back().metrics.at("relmse"));
}

TEST(Tables, TexRowsMatchTheirColumnsAndBracesBalance) {
  RunLog log = small_log();
  add_failure(log, {"a_b%", "sah & co", "{odd}$", 1}, "50% of #1 \\ failed_here ~^");
  const ReportData data = arrange(log);
  for (const Table& table : report_tables(data)) {
    const std::string tex = to_tex(table);
    if (table.rows.empty()) continue;
    EXPECT_EQ(occurrences(tex, "\\toprule"), occurrences(tex, "\\bottomrule"));
    std::size_t columns = 0;
    for (const std::string& line : lines(tex)) {
      if (line.starts_with('%')) continue;
      int depth = 0;
      for (std::size_t i = 0; i < line.size(); ++i) {
        const bool escaped = i > 0 && line[i - 1] == '\\';
        depth += (line[i] == '{') - (line[i] == '}') - (escaped && line[i] == '{') + (escaped && line[i] == '}');
      }
      EXPECT_EQ(depth, 0) << line;
      if (!line.ends_with("\\\\")) {
        columns = 0;
        continue;
      }
      std::size_t fields = 1;
      for (std::size_t i = 0; i < line.size(); ++i) fields += line[i] == '&' && (i == 0 || line[i - 1] != '\\');
      if (columns > 0) {
        EXPECT_EQ(fields, columns) << line;
      }
    }
  }
}

TEST(Tables, StructuresAreInHumanUnits) {
  RunLog log;
  log.structures.push_back(structure("room", "sah", "bvh8", 2, 0.012));
  const Table table = structures_table(arrange(log));
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][column(table, "build_s")].text, "12 ms");
  EXPECT_EQ(table.rows[0][column(table, "bytes")].text, "62.5 KiB");
  EXPECT_EQ(table.rows[0][column(table, "bytes_per_triangle")].raw, "64");
  EXPECT_EQ(table.rows[0][column(table, "diffuse_mrays_per_s_low")].raw, "1.98");
  const std::string speed = to_terminal(table, 3);
  EXPECT_NE(speed.find("2.00 ±1.0 %"), std::string::npos) << speed;
  EXPECT_EQ(table.group_titles, (std::vector<std::string>{"Build and memory", "Tree and work", "Mrays/s, ray by ray"}));
}

TEST(Tables, CountersArePerIteration) {
  const RunLog log = small_log();
  const Table table = counters_table(arrange(log));
  EXPECT_EQ(table.rows[0][column(table, "rays_per_iteration")].raw, "1000");
  EXPECT_EQ(table.rows[0][column(table, "rays_per_s")].raw, "15000");
  EXPECT_EQ(table.columns[column(table, "records_per_iteration")].audience, Audience::machines);  // zero everywhere
}

TEST(Summary, NamesTheLeaderAndItsMargin) {
  const std::string text = summary_table(small_log());
  EXPECT_NE(text.find("sppm has the least relmse at 12.8 s"), std::string::npos) << text;
  EXPECT_NE(text.find("Next comes path"), std::string::npos) << text;
}

TEST(Answers, SayWhetherSeedsTellTheFirstFromTheNext) {
  RunLog log = small_log();
  EXPECT_NE(images_answer(arrange(log)).find("; beyond noise on 1 of 1"), std::string::npos) << images_answer(arrange(log));
  std::erase_if(log.cells, [](const CellRecord& cell) { return cell.cell.seed > 1; });
  EXPECT_NE(images_answer(arrange(log)).find("; too few seeds to tell"), std::string::npos) << images_answer(arrange(log));
}

// A logarithm of zero is none: ranks tell, and nobody blames the number of seeds.
TEST(Answers, RanksTellWhereErrorsAreZero) {
  RunLog log;
  add_cells(log, "builtin:room", {"path", "sah", 0.1, 1, -1}, 8);
  add_cells(log, "builtin:room", {"exact", "sah", 0.1, 0, -1}, 8);
  EXPECT_NE(images_answer(arrange(log)).find("; beyond noise on 1 of 1"), std::string::npos) << images_answer(arrange(log));
  const std::string text = summary_table(log);
  EXPECT_NE(text.find("errors of zero leave no interval; by ranks p = 0.00016"), std::string::npos) << text;
  EXPECT_EQ(text.find("so few seeds the order"), std::string::npos) << text;
}

TEST(Answers, SayWhichStructuresLeadBeyondTheirSpread) {
  RunLog log;
  for (const char* scene : {"a", "b"})
    for (const auto& [name, speed] : {std::pair{"sah", 10.0}, {"lbvh", *scene == 'a' ? 9.95 : 5.0}})
      log.structures.push_back(structure(scene, name, "bvh8", speed, 0.1));  // 1 % about the medians
  EXPECT_NE(structures_answer(log).find("fastest on all 2 scenes; beyond the spread on 1 of 2"), std::string::npos)
      << structures_answer(log);
}

TEST(Tables, OfAMetricWithASignTheLeastComesFirst) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints) record.metrics = {{"bias", record.cell.integrator == "path" ? -0.5 : 0.1}};
  EXPECT_EQ(final_table(arrange(log)).rows.at(0)[1].raw, "sppm");
}

TEST(Summary, OfALogWithoutCellsSaysSo) {
  EXPECT_NE(summary_table({}).find("no finished cell"), std::string::npos);
  RunLog failed;
  add_failure(failed, {"room", "sah", "path", 1}, "boom");
  EXPECT_NE(summary_table(failed).find("1 of 1 cells failed"), std::string::npos);
}

}  // namespace
// The least of signed figures is none of errors.
TEST(Elsewhere, BestBiasHereIsTheOneNearestToZero) {
  RunLog log;
  log.manifests.push_back(manifest());
  for (const char* integrator : {"dark", "sound"}) add_cells(log, "room", {.integrator = integrator}, 3);
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "dark") record.metrics["bias"] = -0.3;
  log.stated.elsewhere = {{"room", "a program", "path", "bias", "a machine", "a day", "a page", 1, 0.01}};
  const Table table = elsewhere_table(arrange(log));
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][column(table, "best")].raw, "sound");
}

TEST(ConfidencePredictions, CountPixelsWithinTheStatedError) {
  Image exact({2, 2}), image({2, 2}), stated({2, 2});
  stated.pixels = {dvec3(0.1), dvec3(0.1), dvec3(0.1), dvec3(0)};
  image.pixels = {dvec3(0.05), dvec3(-0.15), dvec3(0.3), dvec3(0)};
  const auto confidence = confidence_of(image, stated, exact);
  EXPECT_EQ(confidence.at("within_1"), 0.5);
  EXPECT_EQ(confidence.at("within_2"), 0.75);

  RunLog log;
  log.manifests.push_back(manifest());
  log.references.push_back(reference("builtin:exact"));
  log.references.push_back(reference("builtin:rendered", 1e-6));
  for (const char* scene : {"builtin:exact", "builtin:rendered"})
    for (const char* integrator : {"knows", "does not"}) add_cells(log, scene, {.integrator = integrator}, 3);
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "knows") record.confidence = confidence;
  const auto has_note = [](const RunLog& noted) {
    return to_markdown(final_table(arrange(noted))).find("compute it on the clock") != std::string::npos;
  };
  EXPECT_TRUE(has_note(log));
  EXPECT_FALSE(has_note(small_log()));
  const Table table = predictions_table(confidence_predictions(arrange(log)));
  ASSERT_EQ(table.rows.size(), 2u) << "within one standard error, and within two";
  EXPECT_EQ(table.rows[0][column(table, "method")].raw, "knows");
  EXPECT_EQ(table.rows[1][column(table, "measured")].raw, "0.75");
  EXPECT_EQ(table.rows[1][column(table, "verdict")].raw, "refuted") << "95 % are expected";
}

}  // namespace etendue
