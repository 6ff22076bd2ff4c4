// The failure map: what a log's records make of tables, charts and findings.
#include "experiments/kinds/stress/stress_report.h"
#include "tests/unit/kind_records.h"
#include "tests/unit/report_helpers.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using namespace report_test;

// A record whose figure rises from 0.5 by the factor at each of five points.
StressRecord record_of(const std::string& column, double factor, const std::string& remedy = "") {
  StressRecord record;
  record.cell = {"builtin:edge", "stress-01", column + (remedy.empty() ? "" : ": " + remedy), 1};
  record.status = "done";
  record.id = 1;
  record.hazard = "it <breaks>";
  record.parameter = "size";
  record.range = {1, 16};
  record.figure = record.figure_text = "relmse";
  record.holds = {-endless, 1};
  record.column = column;
  record.remedy = remedy;
  for (int i = 0; i < 5; ++i) {
    StressPoint point;
    point.t = i / 4.0;
    point.x = record.range.at(point.t);
    for (const double scale : {0.9, 1.0, 1.1}) point.values.push_back(0.5 * scale * std::pow(factor, i));
    record.points.push_back(point);
  }
  return record;
}

TEST(StressRecord, LineIsReadBack) {
  StressRecord record = record_of("path", 2);
  record.is_expected = true;
  record.expected_low = 3;
  record.parameters = {{"photons", std::int64_t{1000}}};
  const auto read = read_back<StressRecord>(record.line());
  EXPECT_EQ(read.parameters, record.parameters);
  EXPECT_EQ(read.holds.low, -endless);
  EXPECT_FALSE(read.expected_high.has_value());
  EXPECT_EQ(read.line(), record.line());
  EXPECT_EQ(threshold_of(read.curve(), read.holds).t, threshold_of(record.curve(), record.holds).t);
}

TEST(StressReport, JudgesThresholds) {
  const auto verdict = [](double factor, std::optional<double> low, std::optional<double> high) {
    StressRecord record = record_of("path", factor);
    record.is_expected = true;
    record.expected_low = low;
    record.expected_high = high;
    RunLog log;
    add_record(log, record);
    return *judge_stress(arrange_stress(log).rows[0].cells[0])->verdict;
  };
  EXPECT_EQ(verdict(2, 1.8, 2.2), Verdict::confirmed) << "it crosses at the second point, at 2";
  EXPECT_EQ(verdict(2, 6, 9), Verdict::refuted);
  EXPECT_EQ(verdict(1, 16, std::nullopt), Verdict::confirmed) << "it holds to the end";
  EXPECT_EQ(verdict(1, std::nullopt, 8), Verdict::refuted) << "it holds to the end";
}

TEST(StressReport, MatrixHasARowForEachHazardAndAColumnForEachMethod) {
  RunLog log;
  add_record(log, record_of("path", 2));
  add_record(log, record_of("bdpt", 1));
  add_record(log, record_of("path", 1, "more"));
  StressRecord& none = add_record(log, record_of("sppm", 1));
  none.points.clear();
  none.inapplicable = "no photons";
  const StressMap map = arrange_stress(log);
  EXPECT_EQ(map.columns, (std::vector<std::string>{"path", "bdpt", "sppm"}));
  const Table matrix = matrix_table(map, false);
  ASSERT_EQ(matrix.rows.size(), 1u);
  EXPECT_EQ(matrix.rows[0][4].text, "2");
  EXPECT_EQ(matrix.rows[0][5].text, "holds");
  EXPECT_EQ(matrix.rows[0][6].text, "–");
  EXPECT_NE(draw_matrix(map, false, true).svg.find("it &lt;breaks&gt;"), std::string::npos);
  const KindReport report = stress_report(log);
  const auto remedies = std::ranges::find(report.tables, "remedies", &Table::name);
  for (const Table& table : report.tables) EXPECT_TRUE(columns_of_figures_sort(table));
  ASSERT_EQ(remedies->rows.size(), 1u);
  EXPECT_NE(stress_summary(log).find("fails from 2 on"), std::string::npos) << stress_summary(log);
  EXPECT_NE(report.answer.find("breaks 1 of 2"), std::string::npos) << report.answer;
}

TEST(StressReport, MethodsAreComparedOnTheHazardsThatConcernAll) {
  RunLog log;
  add_record(log, record_of("path", 2));
  add_record(log, record_of("bdpt", 4));         // fails sooner
  add_record(log, record_of("bdpt", 1)).id = 2;  // holds where path was not asked
  const KindReport report = stress_report(log);
  EXPECT_TRUE(report.answer.starts_with("path holds widest of 2 methods (")) << report.answer;
  ASSERT_FALSE(report.findings.empty());
  EXPECT_NE(report.findings[0].second.find("0 of 1 to the end"), std::string::npos) << report.findings[0].second;
}

TEST(StressReport, MethodsLookTheSameInAllHazards) {
  RunLog log;
  for (const char* column : {"path", "bdpt", "sppm"}) add_record(log, record_of(column, 2));
  for (const char* column : {"sppm", "path"}) add_record(log, record_of(column, 2)).id = 2;
  add_record(log, record_of("sppm", 1, "more")).id = 2;
  Figure all{.name = "all hazards"};
  for (const FigureGroup& group : stress_report(log).figures)
    for (const Figure& figure : group.figures) all.panels.insert(all.panels.end(), figure.panels.begin(), figure.panels.end());
  ASSERT_EQ(all.panels.size(), 2u);
  EXPECT_EQ(legend_series(all.panels).size(), 4u);
  EXPECT_TRUE(looks_alike_in_all_panels(all));
}

TEST(StressReport, RoundingErrorsDoNotStretchTheAxis) {
  RunLog log;
  add_record(log, record_of("path", 2));
  for (StressPoint& point : add_record(log, record_of("bdpt", 1)).points) point.values = {1e-16, 2e-16};
  const StressMap map = arrange_stress(log);
  const Figure figure = curve_figure(map, map.rows.at(0));
  EXPECT_GT(figure.panels.at(0).y.range->low, 0.1);
  EXPECT_NE(figure.notes.back().find("rounding"), std::string::npos);
  EXPECT_TRUE(well_formed(to_svg(figure)));
}

TEST(StressReport, TheMatrixKeepsRangesOfParametersWithLongNames) {
  RunLog log;
  add_record(log, record_of("path", 2)).parameter = std::string(80, 'w');
  const std::string svg = draw_matrix(arrange_stress(log), false, false).svg;
  EXPECT_NE(svg.find("w…, 1 → 16</text>"), std::string::npos) << svg;
}

TEST(StressReport, AClickSortsTheMatrixByThresholds) {
  RunLog log;
  add_record(log, record_of("path", 2));
  const Table matrix = matrix_table(arrange_stress(log), false);
  EXPECT_EQ(matrix.rows[0][4].order, arrange_stress(log).rows[0].cells[0].threshold->t);
}

// Noise moves a threshold as well.
TEST(StressReport, OneSeedDoesNotTellWhatARemedyMoves) {
  RunLog log;
  for (const double factor : {2.0, 1.9}) {
    StressRecord& record = add_record(log, record_of("path", factor, factor < 2 ? "little" : ""));
    for (StressPoint& point : record.points) point.values.resize(1);
  }
  const StressMap map = arrange_stress(log);
  const std::vector<MendedCell> cells = mended_cells(map);
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_GT(cells[0].factor(), 1);
  EXPECT_FALSE(cells[0].helps());
}

// A method that held before has not been moved to the end, and it is not known how far a threshold beyond the range moved.
TEST(StressReport, RemediesOfWhatHoldsMoveNothing) {
  RunLog log;
  add_record(log, record_of("path", 2));
  add_record(log, record_of("path", 1, "mends"));
  add_record(log, record_of("path", 4, "worsens"));
  StressRecord& noisy = add_record(log, record_of("path", 1, "may mend"));  // holds on the mean, and fails under one seed
  for (StressPoint& point : noisy.points) point.values = {0.1, 0.1, 2.5};
  add_record(log, record_of("bdpt", 1));
  add_record(log, record_of("bdpt", 1, "of no use"));
  const KindReport report = stress_report(log);
  const Table table = remedies_table(mended_cells(arrange_stress(log)));
  const auto cell = [&](std::size_t row, const char* key) { return table.rows[row][column_of(table, key).value()]; };
  EXPECT_EQ(cell(0, "factor").text, "at least 8.0×");
  EXPECT_EQ(cell(0, "factor_high").raw, "");
  EXPECT_EQ(cell(1, "factor").text, "0.71×");
  EXPECT_EQ(cell(2, "factor").text, "at least 8.0×");
  EXPECT_EQ(cell(3, "factor").raw, "") << "both hold to the end";
  EXPECT_NE(to_markdown(table).find("–∞"), std::string::npos) << to_markdown(table);
  const auto found = std::ranges::find(report.findings, "What remedies move", &std::pair<std::string, std::string>::first);
  ASSERT_NE(found, report.findings.end());
  EXPECT_TRUE(found->second.starts_with("1 of 3 remedies move the threshold towards harm, 1 of them to the end"))
      << found->second;
}

// A row of a heat map whose threshold is where x = 2 / y.
StressRecord row_of(double y) {
  StressRecord record = record_of("photon-map", 2);
  record.cell.integrator = fmt::format("photon-map: y={:g}", y);
  record.id = 2;
  record.hazard = "two <of> them";
  record.second = "radius";
  record.second_unit = "m";
  record.y = y;
  record.is_expected = true;
  record.expected_low = record.expected_high = 2 / y;
  for (StressPoint& point : record.points)
    for (double& value : point.values) value *= y;
  return record;
}

TEST(StressReport, RowsMakeAHeatMapOutsideTheMatrix) {
  RunLog log;
  add_record(log, record_of("path", 2));
  add_record(log, row_of(1));
  add_record(log, row_of(0.5));
  StressRecord& off = add_record(log, row_of(0.25));
  off.expected_low = off.expected_high = 1.5;
  const StressMap map = arrange_stress(log);
  ASSERT_EQ(map.rows.size(), 1u);
  ASSERT_EQ(map.grids.size(), 1u);
  EXPECT_EQ(map.columns, (std::vector<std::string>{"path"}));
  EXPECT_EQ(map.grids[0].cells[0].record->y, 0.25) << "rows ascend";
  EXPECT_EQ(judge_stress(map.grids[0].cells[2])->verdict, Verdict::confirmed);
  EXPECT_EQ(judge_stress(map.grids[0].cells[0])->verdict, Verdict::refuted);
  EXPECT_NE(grid_finding(map.grids[0]).find("in 2 of 3 rows, not at radius = 0.25."), std::string::npos)
      << grid_finding(map.grids[0]);
  const Figure figure = grid_figure(map.grids[0]);
  EXPECT_NE(figure.drawing.svg.find("stroke-dasharray"), std::string::npos) << "the predicted boundary";
  EXPECT_TRUE(report_test::well_formed("<svg>" + figure.drawing.svg + "</svg>"));
  const Table table = grid_table(map.grids[0]);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[2][3].text, "2.00 ✗");
  EXPECT_EQ(grid_points_table(map).rows.size(), 15u);
  EXPECT_NE(stress_summary(log).find("photon-map, radius 0.25 m fails from 8 on"), std::string::npos) << stress_summary(log);
  const auto read = read_back<StressRecord>(row_of(0.5).line());
  EXPECT_EQ(read.y, 0.5);
  EXPECT_EQ(read.line(), row_of(0.5).line());
}

// A bound of 0 below does not make the colours those of differences.
TEST(StressReport, AHeatMapOfPositiveFiguresColoursByLogarithms) {
  RunLog log;
  for (const double y : {0.5, 1.0}) {
    StressRecord& record = add_record(log, row_of(y));
    record.holds = {0, 0.1};
    for (StressPoint& point : record.points) point.values.assign(3, std::pow(10.0, 4 * point.t - 2));
  }
  const std::string svg = grid_figure(arrange_stress(log).grids.at(0)).drawing.svg;
  const auto colour_of = [&](const std::string& figure) {
    const std::size_t title = svg.find("relmse " + figure + "<");
    EXPECT_NE(title, std::string::npos) << figure;
    return svg.substr(svg.rfind("fill:#", title) + 5, 7);
  };
  EXPECT_EQ(colour_of("100"), "#6e2002");
  EXPECT_NE(colour_of("1.00"), colour_of("10.0"));
  EXPECT_EQ(colour_of("0.0100"), "#f4fafd") << "the farthest from failing";
}

// A row that fails on the other side of what is sound has the colours of failure.
TEST(StressReport, AHeatMapColoursBothSidesOfTwoBounds) {
  RunLog log;
  for (const double y : {0.25, 1.0}) {
    StressRecord& record = add_record(log, row_of(y));
    record.holds = {-0.5, 0.5};
    for (StressPoint& point : record.points) point.values.assign(3, y < 1 ? -point.t : 0);
  }
  const std::string svg = grid_figure(arrange_stress(log).grids.at(0)).drawing.svg;
  const std::size_t title = svg.find("relmse -1.00"), fill = svg.rfind("fill:#", title);
  ASSERT_NE(title, std::string::npos) << svg;
  EXPECT_EQ(svg.substr(fill, 12), "fill:#6e2002");
}

TEST(StressReport, HiddenTableCountsWhatIntervalsMiss) {
  StressRecord record = record_of("path", 1);
  for (std::size_t i = 0; i < record.points.size(); ++i) {
    StressPoint& point = record.points[i];
    point.bias = i == 0 ? 0.5 : 4e-4;  // the first is off by more than its seeds say, the others within what counts as none
    point.bias_error = i == 0 ? 0.1 : 0;
    point.tails = {1.4, 1.5, 1.6};
    point.sane_iterations = {4, 8, -16};
    point.sane_s = {0.4, 0.8, -1.6};
    point.beyond_stated = 0.25;
  }
  RunLog log;
  add_record(log, record);
  record.column = "bdpt";
  for (StressPoint& point : record.points) point = {{point.t, point.x, point.values}, 0, 0, 0};
  add_record(log, record);  // as lines older than these figures
  const Table table = hidden_table(arrange_stress(log));
  ASSERT_EQ(table.rows.size(), 2u);
  const auto cell = [&](const char* key) { return table.rows[0][*column_of(table, key)]; };
  EXPECT_EQ(*cell("tail_index").order, 1.5);
  EXPECT_EQ(cell("missed").raw, "1");
  EXPECT_EQ(cell("missed_of").raw, "5");
  EXPECT_EQ(*cell("missed_share").order, 0.2) << "whose interval stands behind it";
  EXPECT_EQ(*cell("sane_iterations").order, 8);
  EXPECT_EQ(cell("sane_s_arrived").raw, "2");
  EXPECT_EQ(cell("beyond_stated").text, "25 %");
  EXPECT_EQ(table.rows[1][*column_of(table, "sane_s")].raw, "");
  EXPECT_EQ(read_back<StressRecord>(record.line()).line(), record.line());
  const KindReport report = stress_report(log);
  const auto found =
      std::ranges::find(report.findings, std::string("What a mean hides"), [](const auto& f) { return f.first; });
  ASSERT_NE(found, report.findings.end());
  EXPECT_NE(found->second.find("path 20 % (1–72)"), std::string::npos) << found->second;
  EXPECT_NE(found->second.find("0 of 2 cells never came to a sane image, and the tail index is below 2 in 1,"),
            std::string::npos)
      << found->second;
}

}  // namespace
}  // namespace etendue
