// The report on a method that chooses others.
#include "experiments/report/regret.h"
#include "tests/unit/report_helpers.h"

namespace etendue {
namespace {

using namespace report_test;

std::string cell_of(const Table& table, std::size_t row, const char* key) {
  return table.rows.at(row).at(column_of(table, key).value()).raw;
}

// At the end, after 12.8 s and 128 iterations, sppm has half of the error of path; at a quarter of that a third.
RunLog log_with_choices() {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {.integrator = "auto", .variance = 0.2, .exponent = -2.0 / 3}, 3);
  add_cells(log, "builtin:room", {.integrator = "auto seconds=3.2", .variance = 0.1, .exponent = -2.0 / 3}, 3);
  for (CellRecord& cell : log.cells)
    if (cell.cell.integrator.starts_with("auto")) cell.chosen = "sppm";
  return log;
}

TEST(Regret, IsTheErrorOverTheLeastAtTheTimeThatWasChosenFor) {
  const RunLog log = log_with_choices();
  const KindReport report = regret_report(arrange(log));
  ASSERT_EQ(report.tables.size(), 2u);
  const Table& contests = report.tables[0];
  ASSERT_EQ(contests.rows.size(), 2u);
  for (const std::size_t row : {0u, 1u}) {
    EXPECT_EQ(cell_of(contests, row, "best"), "sppm");
    EXPECT_EQ(cell_of(contests, row, "chosen"), "sppm");
    EXPECT_NEAR(std::stod(cell_of(contests, row, "time_s")), row == 0 ? 3.2 : 12.8, 1e-6);
    EXPECT_NEAR(std::stod(cell_of(contests, row, "regret")), row == 0 ? 1 : 2, 1e-6);
  }
  const Table& losses = report.tables[1];  // the least median first
  ASSERT_EQ(losses.rows.size(), 3u);
  EXPECT_EQ(cell_of(losses, 0, "method"), "sppm sah");
  EXPECT_NEAR(std::stod(cell_of(losses, 0, "worst_regret")), 1, 1e-6);
  EXPECT_EQ(cell_of(losses, 1, "method"), "auto");
  EXPECT_NEAR(std::stod(cell_of(losses, 1, "median_regret")), 1.5, 1e-6);
  EXPECT_NEAR(std::stod(cell_of(losses, 1, "worst_regret")), 2, 1e-6);
  EXPECT_NE(report.answer.find("auto errs 1.50 times"), std::string::npos) << report.answer;
  ASSERT_EQ(report.figures.size(), 1u);
  EXPECT_EQ(report.figures[0].figures[0].panels.size(), 2u);
  EXPECT_TRUE(well_formed(to_svg(report.figures[0].figures[0])));
}

// On a structure whose rays take longer a method errs more, chosen or not.
TEST(Regret, ComparesMethodsOnOneStructure) {
  RunLog log = log_with_choices();
  for (const char* name : {"sppm", "auto"})
    add_cells(log, "builtin:room", {.integrator = name, .accel = "octree", .variance = 10, .exponent = -2.0 / 3}, 3);
  const KindReport report = regret_report(arrange(log));
  const Table& contests = report.tables.at(0);
  ASSERT_EQ(contests.rows.size(), 3u);
  for (std::size_t row = 0; row < 3; ++row)
    EXPECT_NEAR(std::stod(cell_of(contests, row, "regret")), cell_of(contests, row, "accel") == "octree" || row == 0 ? 1 : 2,
                1e-6);
  EXPECT_NE(report.answer.find("auto errs 1.00 times"), std::string::npos) << report.answer;
}

TEST(Regret, AChoiceThatErrsLessThanAnyOneMethodIsOnTheChart) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {.integrator = "auto", .variance = 0.03, .exponent = -2.0 / 3}, 3);
  const KindReport report = regret_report(arrange(log));
  for (const Chart& panel : report.figures.at(0).figures.at(0).panels) {
    const auto own = std::ranges::find(panel.series, "auto", &ChartSeries::key);
    ASSERT_NE(own, panel.series.end());
    EXPECT_NEAR(own->points.at(0).x, 0.3, 1e-6);
    EXPECT_LT(panel.x.range->low, 0.3);
  }
}

TEST(Regret, NamesEveryMethodThatASeedChose) {
  RunLog log = log_with_choices();
  log.cells.back().chosen = "path";
  const KindReport report = regret_report(arrange(log));
  EXPECT_EQ(cell_of(report.tables.at(0), 0, "chosen"), "sppm; path");
}

TEST(Regret, AMethodThatFailedHasNoImage) {
  RunLog log = log_with_choices();
  for (const std::uint64_t seed : {1, 2, 3}) add_failure(log, {"builtin:room", "sah", "bdpt", seed}, "out of memory");
  const Table losses = regret_report(arrange(log)).tables.at(1);
  ASSERT_EQ(losses.rows.size(), 4u);
  EXPECT_EQ(cell_of(losses, 3, "method"), "bdpt sah");
  EXPECT_EQ(cell_of(losses, 3, "without_image"), "2");
  EXPECT_EQ(cell_of(losses, 3, "worst_regret"), "no image");
}

TEST(Regret, IsNotToldWhereNothingWasChosen) {
  const RunLog log = small_log();
  EXPECT_TRUE(regret_report(arrange(log)).tables.empty());
}

TEST(Regret, ABiasHasNone) {
  RunLog log = log_with_choices();
  for (CheckpointRecord& record : log.checkpoints) record.metrics = {{"bias", -0.1}};
  EXPECT_TRUE(regret_report(arrange(log)).tables.empty()) << "the most negative is not the least";
}

}  // namespace
}  // namespace etendue
