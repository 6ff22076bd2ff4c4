#include "experiments/report/results/changes.h"
#include "framework/core/error.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

struct Row {
  std::string method;
  double value, low, high;
};

Table table_of(const std::vector<Row>& rows) {
  Table table{"final", "Errors", {}, {}, {}, {}};
  table.columns = {
      {"method", "method", false}, {"relmse_mean", ""}, {"relmse_low", ""}, {"relmse_high", ""}, {"seeds", "seeds"}};
  for (const Row& row : rows) table.rows.push_back({row.method, row.value, row.low, row.high, 3});
  return table;
}

TEST(Changes, FiguresWhoseIntervalsDoNotMeetHaveMoved) {
  const std::vector<Table> then{table_of({{"path", 1, 0.9, 1.1}, {"sppm", 2, 1.8, 2.2}, {"gone", 1, 1, 1}})},
      now{table_of({{"sppm", 1.5, 1.4, 1.6}, {"path", 1.15, 1.05, 1.3}, {"new", 1, 1, 1}})};
  const auto changes = compare_tables(then, now);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].row, "sppm");
  EXPECT_EQ(changes[0].column, "relmse_mean");
  EXPECT_TRUE(changes[0].moved());
  EXPECT_FALSE(changes[1].moved());
  const LogChanges kept = changes_between("a1", then, "b2", now);
  EXPECT_EQ(kept.moved, 1u);
  EXPECT_EQ(kept.better, 1u);
  EXPECT_EQ(kept.worse, 0u);
  ASSERT_EQ(kept.most.size(), 1u);
  EXPECT_EQ(kept.most[0].ratio(), 0.75);
  EXPECT_EQ(kept.sentence(), "From a1 to b2. 2 figures with intervals were compared; those of 1 do not overlap.");
  const std::string page = changes_page(kept);
  EXPECT_NE(page.find("sppm"), std::string::npos) << page;
  EXPECT_NE(page.find("better"), std::string::npos) << page;
  EXPECT_NE(page.find(kept.sentence()), std::string::npos) << page;
}

// Where iterations end the runs, the scene's common time is that of the fastest program, and errors then go with it.
TEST(Changes, ErrorsAtAnotherTimeAreNotCompared) {
  const auto at = [](double time_s, double error) {
    Table table{"final", "Errors", {}, {}, {}, {}};
    const std::string then = "relmse_at_common_time_";
    table.columns = {
        {"method", "method", false}, {"common_time_s", ""}, {then + "mean", ""}, {then + "low", ""}, {then + "high", ""}};
    table.rows.push_back({"sppm", time_s, error, 0.9 * error, 1.1 * error});
    return std::vector{std::move(table)};
  };
  EXPECT_EQ(compare_tables(at(10, 1), at(10.01, 2)).size(), 1u);
  EXPECT_TRUE(compare_tables(at(10, 1), at(5, 2)).empty());
}

// One seed tells nothing of noise, and two have extremes alone.
TEST(Changes, FiguresOfOneSeedHaveNoInterval) {
  const auto of = [](const char* interval, double error) {
    Table table{"final", "Errors", {}, {}, {}, {}};
    table.columns = {{"method", "method", false}, {"x_mean", ""}, {"x_low", ""}, {"x_high", ""}, {"x_interval", ""}};
    table.rows.push_back({"sppm", error, error, error, interval});
    return std::vector{std::move(table)};
  };
  EXPECT_EQ(compare_tables(of("t95", 1), of("t95", 2)).size(), 1u);
  EXPECT_TRUE(compare_tables(of("none", 1), of("none", 2)).empty());
  EXPECT_TRUE(compare_tables(of("min-max", 1), of("t95", 2)).empty());
}

TEST(Changes, ThoseByTheLargestFactorsAreKeptAndAllAreCounted) {
  std::vector<Row> before, after;
  for (int i = 0; i < 80; ++i) {
    before.push_back({"method " + std::to_string(i), 1, 1, 1});
    after.push_back({"method " + std::to_string(i), 2.0 + i, 2.0 + i, 2.0 + i});
  }
  const LogChanges kept = changes_between("a", std::vector{table_of(before)}, "b", std::vector{table_of(after)});
  EXPECT_EQ(kept.moved, 80u);
  EXPECT_EQ(kept.worse, 80u);
  ASSERT_EQ(kept.most.size(), 12u);
  EXPECT_EQ(kept.most[0].now, 81);
  EXPECT_EQ(kept.most[11].now, 70);
}

TEST(Changes, RowsOfEqualNamesAreHeldAgainstEachOtherInOrder) {
  const std::vector<Table> then{table_of({{"path", 1, 1, 1}, {"path", 5, 5, 5}})},
      now{table_of({{"path", 1, 1, 1}, {"path", 4, 4, 4}})};
  const auto changes = compare_tables(then, now);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_FALSE(changes[0].moved());
  EXPECT_EQ(changes[1].then, 5);
}

TEST(Changes, AreKeptAsTextWhoseChecksumTellsWhatIsChangedByHand) {
  LogChanges changes{
      "a1", "b2-dirty", 1234, 7, 4, 3, {{"final", "room, path\tn=2", "mse_mean", 0.1, 1e-9, 0.05, 0.15, 1e-10, 2e-9}}};
  const std::string text = to_text(changes);
  const LogChanges read = read_changes("x", text);
  EXPECT_EQ(read.from, "a1");
  EXPECT_EQ(read.to, "b2-dirty");
  EXPECT_EQ(read.compared, 1234u);
  EXPECT_EQ(read.moved, 7u);
  EXPECT_EQ(read.better, 4u);
  EXPECT_EQ(read.worse, 3u);
  ASSERT_EQ(read.most.size(), 1u);
  EXPECT_EQ(read.most[0].row, "room, path n=2") << "a tab would end the field";
  EXPECT_EQ(read.most[0].then, 0.1);
  EXPECT_EQ(read.most[0].now_high, 2e-9);
  EXPECT_EQ(to_text(read), text);
  std::string changed = text;
  changed[changed.find("0.1")] = '9';
  for (const std::string& wrong : {changed, text.substr(0, text.size() - 3), text + "\n", std::string(), std::string("\n")})
    EXPECT_THROW(read_changes("x", wrong), Error) << wrong;
}

TEST(Changes, WhatGotWorseIsToldByTheNameOfTheFigure) {
  const auto worse = [](const char* column) {
    FigureChange change{"t", "r", column};
    change.then = 1;
    change.now = 2;
    return change.got_worse();
  };
  for (const char* less_is_better : {"relmse_mean", "mse", "rmse", "build_s", "time_s_median", "memory_bytes"})
    EXPECT_EQ(worse(less_is_better), true) << less_is_better;
  for (const char* more_is_better : {"samples_per_s", "diffuse_mrays_per_s", "shadow_to_embree"})
    EXPECT_EQ(worse(more_is_better), false) << more_is_better;
  for (const char* neither : {"bias_mean", "records", "exponent", "stated"}) EXPECT_EQ(worse(neither), std::nullopt) << neither;
}

TEST(Changes, OfAllExperimentsStandInOneTable) {
  const FigureChange slower{"structures", "room, sah", "mrays_per_s", 4, 2, 3.9, 4.1, 1.9, 2.1};
  const Table table = moved_table({{"a", {"1", "2", 10, 3, 1, 1, {slower}}}, {"b", {"1", "2", 7, 0, 0, 0, {}}}});
  ASSERT_EQ(table.rows.size(), 2u);
  const auto cell = [&](std::size_t row, std::string_view key) { return table.rows[row][column_of(table, key).value()].raw; };
  EXPECT_EQ(cell(0, "experiment"), "a");
  EXPECT_EQ(cell(0, "compared"), "10");
  EXPECT_EQ(cell(0, "moved"), "3");
  EXPECT_EQ(cell(0, "better"), "1");
  EXPECT_EQ(cell(0, "worse"), "1");
  EXPECT_EQ(cell(0, "most"), "0.5");
  EXPECT_EQ(cell(0, "of"), "mrays_per_s of room, sah (structures)");
  EXPECT_EQ(cell(1, "moved"), "0");
  EXPECT_EQ(cell(1, "most"), "");
}

TEST(Changes, PredictionsAreComparedWhateverTheirVerdicts) {
  const auto table = [](const char* verdict, double value) {
    Table made{"predictions", "Predictions", {{"method", "method", false}, {"measured", ""}, {"low", ""}, {"high", ""}}};
    made.columns.push_back({"verdict", "verdict", false, Audience::everyone, 1});
    made.rows.push_back({"path", value, value - 0.1, value + 0.1, verdict});
    return std::vector{made};
  };
  const auto changes = compare_tables(table("confirmed", 1), table("refuted", 2));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].column, "measured");
  EXPECT_TRUE(changes[0].moved());
  EXPECT_EQ(changes[0].got_worse(), std::nullopt);
}

// The figure that moved the farthest changes its verdict, and must not be left out for that.
TEST(Changes, WordsThatSayWhatWasFoundDoNotNameARow) {
  const auto table = [](const char* verdict, double value) {
    Table made{"ledger-scenes", "Decisions", {{"component", "component", false}, {"verdict", "verdict", false}}};
    for (const char* key : {"error", "error_low", "error_high"}) made.columns.push_back({key, ""});
    made.rows.push_back({"caustic map", verdict, value, value - 0.1, value + 0.1});
    return std::vector{made};
  };
  const auto changes = compare_tables(table("earns its time", 2), table("contradicted", 0.5));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].row, "caustic map");
  EXPECT_TRUE(changes[0].moved());
}

TEST(Changes, TablesOfOneLogAloneAreLeftOut) {
  EXPECT_TRUE(compare_tables({}, std::vector{table_of({{"path", 1, 1, 1}})}).empty());
}

// Rows that numbers alone tell apart, such as sizes of one set: without one of them no row can be told from the next.
TEST(Changes, RowsOfOneNameAreComparedWhereNoneIsMissing) {
  const std::vector<Table> then{table_of({{"grid", 1, 0.9, 1.1}, {"grid", 10, 9, 11}, {"tree", 1, 0.9, 1.1}})},
      now{table_of({{"grid", 10, 9, 11}, {"tree", 2, 1.9, 2.1}})};
  const auto changes = compare_tables(then, now);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].row, "tree");
}

}  // namespace
}  // namespace etendue
