#include "experiments/report/results/changes.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

struct Row {
  const char* method;
  double value, low, high;
};

Table table_of(std::initializer_list<Row> rows) {
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
  const Table table = changes_table(changes);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0].back().raw, "0.75");
  EXPECT_EQ(table.notes.front(), "2 figures with intervals were compared; those of 1 do not overlap.");
}

TEST(Changes, RowsOfEqualNamesAreHeldAgainstEachOtherInOrder) {
  const std::vector<Table> then{table_of({{"path", 1, 1, 1}, {"path", 5, 5, 5}})},
      now{table_of({{"path", 1, 1, 1}, {"path", 4, 4, 4}})};
  const auto changes = compare_tables(then, now);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_FALSE(changes[0].moved());
  EXPECT_EQ(changes[1].then, 5);
}

TEST(Changes, TablesOfOneLogAloneAreLeftOut) {
  EXPECT_TRUE(compare_tables({}, std::vector{table_of({{"path", 1, 1, 1}})}).empty());
}

}  // namespace
}  // namespace etendue
