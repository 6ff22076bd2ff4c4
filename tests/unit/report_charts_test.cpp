#include "experiments/report/charts/chart_plot.h"
#include "experiments/report/charts/charts.h"
#include "experiments/report/structures/structure_figures.h"
#include "tests/unit/report_helpers.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace etendue {
namespace {

using namespace report_test;

std::vector<std::string> labels(Interval range, Scale scale, int most) {
  std::vector<std::string> result;
  for (const Tick& tick : ticks(range, scale, most))
    if (!tick.label.empty()) result.push_back(tick.label);
  return result;
}

using Labels = std::vector<std::string>;

TEST(Ticks, LogAxesAreLabelledAtDecadesOr125) {
  EXPECT_EQ(labels({0.9, 1100}, Scale::log, 6), (Labels{"1", "10", "100", "1000"}));
  EXPECT_EQ(labels({0.9, 11}, Scale::log, 8), (Labels{"1", "2", "5", "10"}));
  EXPECT_EQ(labels({1.5e-6, 2e-2}, Scale::log, 5), (Labels{"10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"}));
  EXPECT_EQ(labels({1e-12, 1}, Scale::log, 5), (Labels{"10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"}));
  EXPECT_EQ(labels({3.1, 4.9}, Scale::log, 5), (Labels{"3.5", "4.0", "4.5"}));  // less than a decade: as on a linear axis
}

TEST(Ticks, LogAxesHaveMinorTicksBetween) {
  const auto all = ticks({1, 100}, Scale::log, 2);
  EXPECT_EQ(all.size(), 19u);
  EXPECT_DOUBLE_EQ(all[1].value, 2);
}

TEST(Ticks, LinearStepsAreRound) {
  EXPECT_EQ(labels({-0.013, 0.021}, Scale::linear, 4), (Labels{"−0.01", "0.00", "0.01", "0.02"}));
  EXPECT_EQ(labels({0, 1}, Scale::linear, 5), (Labels{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
  EXPECT_EQ(labels({0, 2.4e6}, Scale::linear, 3), (Labels{"0", "1·10⁶", "2·10⁶"}));
}

TEST(Ticks, NeverRunAway) {
  for (const Interval range : {Interval{1e-300, 1e300}, Interval{1, 1.0000001}, Interval{1e-8, 1.1e-8}, Interval{0.5, 2}})
    for (const Scale scale : {Scale::log, Scale::linear})
      for (const int most : {2, 8}) {
        const auto found = ticks(range, scale, most);
        EXPECT_LT(found.size(), 800u);
        for (const Tick& tick : found) EXPECT_TRUE(std::isfinite(tick.value));
      }
}

TEST(Range, ShowsAllPositiveValuesOnALogAxis) {
  const Interval range = padded_range({1e-3, 10, 0, -1}, Scale::log);
  EXPECT_LT(range.low, 1e-3);
  EXPECT_GT(range.high, 10);
  EXPECT_GT(range.low, 1e-4);
  const Interval nothing = padded_range({0, 0}, Scale::log);
  EXPECT_LT(nothing.low, nothing.high);
  const Interval one = padded_range({5}, Scale::linear);
  EXPECT_LT(one.low, 5);
  EXPECT_GT(one.high, 5);
}

TEST(Range, OfWhatNoMeasurementIsStaysFinite) {
  for (const Scale scale : {Scale::log, Scale::linear}) {
    const Interval range = padded_range({1e308, -1e308, 1e-320, 3, 5}, scale);
    EXPECT_GT(range.low, scale == Scale::log ? 1 : -1);
    EXPECT_LT(range.low, range.high);
    EXPECT_LT(range.high, 10);
  }
}

Figure over_time(const RunLog& log, const std::string& metric = "relmse", Scale scale = Scale::log) {
  const ReportData data = arrange(log);
  return error_figure(data, data.scenes.at(0), metric, Abscissa::time, scale);
}

TEST(Charts, EveryFileIsWellFormedAndFinite) {
  RunLog log = small_log();
  log.structures = {structure("builtin:room", "sah", "bvh8", 2, 0.1), structure("builtin:room", "lbvh", "binary", 1, 0.01),
                    structure("builtin:room", "brute", "-", 1e-4, 0)};
  const ReportData data = arrange(log);
  std::vector<Figure> figures = file_figures(data);
  EXPECT_EQ(figures.size(), 3u * 2 + 2);  // metrics over time and iterations, fronts of the unsigned
  const KindReport structures = structures_report(data);
  ASSERT_EQ(structures.figures.size(), 1u);  // of the scene
  EXPECT_EQ(structures.figures[0].figures.size(), 3u);
  figures.insert(figures.end(), structures.figures[0].figures.begin(), structures.figures[0].figures.end());
  for (const Figure& figure : figures) {
    const std::string svg = to_svg(figure);
    EXPECT_TRUE(well_formed(svg)) << figure.name;
    for (const char* bad : {"nan", "inf,", "inf ", "\"inf"})
      EXPECT_EQ(svg.find(bad), std::string::npos) << figure.name << " has " << bad;
    EXPECT_NE(svg.find("xmlns="), std::string::npos);
    EXPECT_EQ(occurrences(svg, "http"), 1u) << "only the namespace is an address";
  }
}

TEST(Charts, NamesFromTheLogAreEscaped) {
  RunLog log;
  add_cells(log, "a<script>&\"", {"p<b>'\"&", "s]]>"}, 2);
  add_cells(log, "a<script>&\"", {"other", "s]]>"}, 2);
  for (const Figure& figure : file_figures(arrange(log))) {
    const std::string svg = to_svg(figure);
    EXPECT_TRUE(well_formed(svg)) << figure.name;
    EXPECT_EQ(svg.find("<script"), std::string::npos);
    EXPECT_EQ(svg.find("<b>"), std::string::npos);
    EXPECT_EQ(figure.name.find_first_of("<>&\"/ "), std::string::npos);
  }
}

TEST(Charts, BandIsDrawnFromSeveralSeedsOnlyAndSaidSo) {
  RunLog one;
  add_cells(one, "room", {}, 1);
  const Figure without = over_time(one);
  EXPECT_EQ(to_svg(without).find("class=\"band\""), std::string::npos);
  EXPECT_EQ(without.notes.at(0), "One seed: no band can be drawn.");
  RunLog three;
  add_cells(three, "room", {}, 3);
  const Figure with = over_time(three);
  EXPECT_NE(to_svg(with).find("class=\"band\""), std::string::npos);
  EXPECT_NE(with.notes.at(0).find("95 % Student interval"), std::string::npos);
}

TEST(Charts, ZeroErrorIsMarkedOnTheLowerEdge) {
  RunLog log;
  add_cells(log, "room", {}, 1);
  log.checkpoints.back().metrics["relmse"] = 0;
  const Figure figure = over_time(log);
  EXPECT_TRUE(std::any_of(figure.notes.begin(), figure.notes.end(),
                          [](const auto& n) { return n.find("error of zero") != std::string::npos; }));
  EXPECT_EQ(occurrences(to_svg(figure), "class=\"mark open\""), 1u);
}

TEST(Charts, ManySeriesSplitIntoPanelsByIntegrator) {
  RunLog log;
  for (const char* integrator : {"path", "bdpt", "sppm"})
    for (const char* accel : {"sah", "median", "lbvh", "grid"}) add_cells(log, "room", {integrator, accel}, 1);
  const Figure figure = over_time(log);
  ASSERT_EQ(figure.panels.size(), 3u);
  EXPECT_EQ(figure.panels[0].title, "path");
  // All panels have the same axes, and each shows the others' curves behind.
  EXPECT_EQ(figure.panels[0].x.range->low, figure.panels[2].x.range->low);
  const auto grey = std::count_if(figure.panels[0].series.begin(), figure.panels[0].series.end(),
                                  [](const ChartSeries& s) { return s.draw == ChartSeries::Draw::context; });
  EXPECT_EQ(grey, 8);
  EXPECT_TRUE(well_formed(to_svg(figure)));
}

TEST(Charts, StructuresCoincideOverIterations) {
  RunLog log;
  add_cells(log, "room", {"path", "sah", 0.1}, 2);
  add_cells(log, "room", {"path", "median", 0.2}, 2);
  const ReportData data = arrange(log);
  const auto note = [&](const ReportData& d) {
    return error_figure(d, d.scenes[0], "relmse", Abscissa::iterations, Scale::log).notes.at(1);
  };
  EXPECT_NE(note(data).find("equal to the last bit"), std::string::npos);
  log.checkpoints.back().metrics["relmse"] *= 1.001;
  EXPECT_NE(note(arrange(log)).find("differ"), std::string::npos);
}

TEST(Charts, SignedMetricIsDrawnOnALinearAxis) {
  const Figure figure = over_time(small_log(), "bias");
  EXPECT_EQ(figure.panels.at(0).y.scale, Scale::linear);
  EXPECT_EQ(figure.panels.at(0).x.scale, Scale::log);
}

TEST(Charts, LinearAxisShowsTheLastErrors) {
  const Figure figure = over_time(small_log(), "relmse", Scale::linear);
  EXPECT_LT(figure.panels.at(0).y.range->high, 0.06);  // the first errors are near 1, the last near 0.008
  EXPECT_NE(figure.notes.at(1).find("linear axis ends"), std::string::npos);
  EXPECT_TRUE(well_formed(to_svg(figure)));
}

TEST(Charts, MetricThatOneMethodLacksLeavesOnlyThatOut) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints)
    if (record.cell.integrator == "path") record.metrics.erase("mse");
  const Figure figure = over_time(log, "mse");
  ASSERT_EQ(figure.panels.size(), 1u);
  ASSERT_EQ(figure.panels[0].series.size(), 1u);
  EXPECT_EQ(figure.panels[0].series[0].label, "sppm");
  EXPECT_TRUE(over_time(log, "unknown").empty());
}

TEST(Charts, FrontNamesAndMarksWhatNothingBeats) {
  const RunLog log = small_log();
  const ReportData data = arrange(log);
  const Figure figure = front_figure(data, data.scenes[0], "relmse", Scale::log);
  ASSERT_FALSE(figure.empty());
  const Chart& chart = figure.panels[0];
  const auto bold = std::count_if(chart.series.begin(), chart.series.end(),
                                  [](const ChartSeries& s) { return s.draw == ChartSeries::Draw::dots && !s.points.empty(); });
  EXPECT_GT(bold, 0);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(chart.labels.size()), bold);
  const auto front = std::find_if(chart.series.begin(), chart.series.end(), [](const auto& s) { return s.key == "front"; });
  ASSERT_NE(front, chart.series.end());
  for (std::size_t i = 1; i < front->points.size(); ++i) EXPECT_LT(front->points[i].y, front->points[i - 1].y);
  EXPECT_EQ(front_figure(data, data.scenes[0], "bias", Scale::log).panels.at(0).y.title, "|bias|");
}

TEST(Charts, BandsEndAtTheFrame) {
  Chart chart{.x = {"x", Scale::linear, Interval{0, 2}}, .y = {"y", Scale::linear, Interval{0, 1}}};
  chart.series.push_back({.key = "k", .points = {{0, 0.5, 0.2, 0.8}, {1, 0.5, 0.2, 3}, {2, 0.5, 0.2, 0.8}}});
  const Plot plot(chart, {0, 0, 400, 300}, false);
  const std::string svg = plot.svg();
  const std::size_t begin = svg.find("class=\"band\" d=\"") + 16;
  std::string path = svg.substr(begin, svg.find('"', begin) - begin);
  EXPECT_EQ(occurrences(path, " " + px(plot.box().top)), 2u) << "the band leaves the frame and comes back: " << path;
  std::ranges::replace_if(
      path, [](char c) { return c == 'M' || c == 'L' || c == 'Z'; }, ' ');
  std::istringstream numbers(path);
  for (double x, y; numbers >> x >> y;) EXPECT_GE(y, plot.box().top - 0.05) << path;
}

// A page sets letters of 16 pixels on a phone.
TEST(Charts, NamesOfRowsFitTheirMargin) {
  const std::string name = "sah reinsertion=9 isa=avx512";
  Chart chart{.rows = {name, "grid"}};
  chart.series.push_back({.key = "k", .label = "k", .points = {{1, 0}, {2, 1}}});
  EXPECT_GE(Plot(chart, {0, 0, 720, 200}, false).box().left - 8, text_width(name, 16));
}

TEST(Charts, FiguresFromElsewhereLookAlikeInAllScenes) {
  RunLog log;
  for (const char* scene : {"room", "hall"}) add_cells(log, scene, {}, 1);
  for (const auto& [scene, method] : {std::pair("room", "path"), {"room", "bdpt"}, {"hall", "bdpt"}})
    log.stated.elsewhere.push_back({scene, "a program", method, "relmse", "a machine", "a day", "a page", 1, 0.01});
  const ReportData data = arrange(log);
  Figure all{.name = "all scenes"};
  for (const SceneData& scene : data.scenes)
    all.panels.push_back(error_figure(data, scene, "relmse", Abscissa::time, Scale::log).panels.at(0));
  EXPECT_EQ(legend_series(all.panels).size(), 3u);
  EXPECT_TRUE(looks_alike_in_all_panels(all));
}

TEST(Charts, OutlyingStructureIsNamedNotDrawn) {
  RunLog log;
  log.structures = {structure("room", "sah", "bvh8", 2, 0.1), structure("room", "lbvh", "bvh8", 1, 0.01),
                    structure("room", "sbvh", "bvh8", 2.5, 0.5), structure("room", "brute", "-", 1e-4, 0)};
  const ReportData data = arrange(log);
  const Figure figure = structures_figure(data, data.scenes.at(0));
  EXPECT_NE(figure.notes.at(0).find("brute"), std::string::npos);
  for (const ChartSeries& series : figure.panels.at(0).series) EXPECT_NE(series.label, "brute");
}

TEST(Charts, CheapestStructuresFollowEachOtherWhereTheirTotalsMeet) {
  // Mrays/s and seconds: brute 0.001 (1 ms a ray), lbvh 1 (1 us), sah 2 (0.5 us), and one that is beaten everywhere.
  const StructureRecord brute = structure("room", "brute", "-", 1e-3, 1e-3),
                        lbvh = structure("room", "lbvh", "binary", 1, 0.011), sah = structure("room", "sah", "bvh8", 2, 0.111),
                        bad = structure("room", "bad", "-", 0.5, 0.2);
  StructureRecord skipped = structure("room", "skipped", "-", 0, 0);
  const auto choices = cheapest_choices({&skipped, &bad, &sah, &brute, &lbvh});
  ASSERT_EQ(choices.size(), 3u);
  EXPECT_EQ(choices[0].record, &brute);
  EXPECT_EQ(choices[0].from_rays, 0);
  EXPECT_EQ(choices[1].record, &lbvh);
  EXPECT_NEAR(choices[1].from_rays, 0.010 / (1e-3 - 1e-6), 1e-6);
  EXPECT_EQ(choices[2].record, &sah);
  EXPECT_NEAR(choices[2].from_rays, 0.1 / 0.5e-6, 1);
  EXPECT_TRUE(cheapest_choices({&skipped}).empty());
}

TEST(Charts, BreakEvenDrawsEachChoiceWhereItIsTheOneToPick) {
  RunLog log;
  log.structures = {structure("room", "lbvh", "binary", 1, 0.011), structure("room", "sah", "bvh8", 2, 0.111),
                    structure("room", "bad", "-", 0.5, 0.2)};
  const ReportData data = arrange(log);
  const Figure figure = break_even_figure(data, data.scenes.at(0));
  EXPECT_EQ(figure.notes.at(0), "To pick: lbvh binary; sah bvh8 from 200 k rays.");
  const auto& series = figure.panels.at(0).series;
  std::map<std::string, const ChartSeries*> by_key;
  for (const ChartSeries& s : series) by_key[s.key] = &s;
  EXPECT_EQ(std::count_if(series.begin(), series.end(), [](const auto& s) { return s.draw == ChartSeries::Draw::context; }), 3);
  ASSERT_TRUE(by_key.contains("lbvh binary") && by_key.contains("sah bvh8"));
  EXPECT_NEAR(by_key["lbvh binary"]->points.back().x, 2e5, 1);
  EXPECT_NEAR(by_key["sah bvh8"]->points.front().x, 2e5, 1);
  EXPECT_NEAR(by_key["sah bvh8"]->points.front().y, by_key["lbvh binary"]->points.back().y, 1e-9);
}

TEST(Charts, ScenesThatDifferInANumberMakeASweep) {
  RunLog log;
  const auto add = [&](const std::string& scene, double mrays) {
    log.structures.push_back(structure(scene, "sah", "bvh8", mrays, 0.1));
    log.structures.push_back(structure(scene, "grid", "-", mrays / 2, 0.1));
  };
  for (const auto& [count, mrays] : {std::pair{"1e3", 9.0}, {"10k", 8.0}, {"100000", 7.0}})
    add(std::string("builtin:mesh?triangles=") + count, mrays);
  for (const char* size : {"10", "20"}) add(std::string("builtin:stadium?size=") + size, 1);  // two are no sweep
  add("builtin:room", 3);
  log.structures.push_back(structure("builtin:mesh?triangles=1e3", "kd-tree", "-", 0, 0));
  log.structures.back().note = "not built";
  const ReportData data = arrange(log);
  const auto figures = structure_sweep_figures(data);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].scene, "builtin:mesh");
  ASSERT_EQ(figures[0].panels.size(), 3u);
  const Chart& cost = figures[0].panels[0];
  EXPECT_EQ(cost.x.title, "triangles");
  ASSERT_EQ(cost.series.size(), 2u);
  ASSERT_EQ(cost.series[0].points.size(), 3u);
  EXPECT_EQ(cost.series[0].points[1].x, 1e4);
  EXPECT_DOUBLE_EQ(cost.series[0].points[1].y, 1e3 / 8);
  EXPECT_LT(cost.series[0].points[1].low, cost.series[0].points[1].y);
  EXPECT_EQ(figures[0].notes.at(0), "kd-tree, builtin:mesh?triangles=1e3: not built.");
  EXPECT_TRUE(well_formed(to_svg(figures[0])));
}

TEST(Charts, StructuresAreComparedOverScenesWithTheFastestOfEach) {
  RunLog log;
  log.structures = {structure("even", "sah", "bvh8", 4, 0.1),    structure("even", "grid", "-", 2, 0.1),
                    structure("even", "brute", "-", 1e-3, 0.1),  structure("uneven", "sah", "bvh8", 2, 0.1),
                    structure("uneven", "grid", "-", 0.01, 0.1), structure("uneven", "brute", "-", 1e-3, 0.1)};
  const Figure figure = structures_over_scenes_figure(arrange(log));
  ASSERT_FALSE(figure.empty());
  const Chart& chart = figure.panels[0];
  EXPECT_EQ(chart.rows, (std::vector<std::string>{"sah bvh8", "grid"}));
  ASSERT_EQ(chart.series.size(), 2u);
  EXPECT_NEAR(chart.series[0].points[1].x, 2, 1e-9);    // the grid in the even scene
  EXPECT_NEAR(chart.series[1].points[1].x, 200, 1e-9);  // and in the uneven one
  EXPECT_NE(figure.notes.at(1).find("brute"), std::string::npos);
  log.structures.resize(3);
  EXPECT_TRUE(structures_over_scenes_figure(arrange(log)).empty());
}

TEST(Charts, LegendsLeaveOutWhatAPanelsTitleNames) {
  const auto panel = [](const std::string& title, const std::vector<std::string>& labels) {
    Chart chart;
    chart.title = title;
    for (const std::string& label : labels) {
      ChartSeries series;
      series.key = series.label = label;
      series.points = {{1, 1, 1, 1}, {2, 0.5, 0.5, 0.5}};
      chart.series.push_back(series);
    }
    return chart;
  };
  const auto times = [](const std::string& text, const std::string& word) {
    int count = 0;
    for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
  };
  const std::string svg = standalone_svg("t", std::vector{panel("alone", {"alone"}), panel("two", {"two", "third"})}, {});
  EXPECT_EQ(times(svg, ">alone<"), 1);
  EXPECT_EQ(times(svg, ">two<"), 2);
  EXPECT_EQ(times(svg, ">third<"), 1);
}

TEST(Charts, CountsAreWholeInReadOuts) {
  Chart chart{.x = {"iterations"}};
  chart.series.push_back({.key = "k", .label = "k", .points = {{1024, 0.5}, {16384, 0.25}}});
  const std::string svg = inline_svg(chart);
  EXPECT_NE(svg.find(",1024,0.5;"), std::string::npos) << svg;
  EXPECT_NE(svg.find(",16384,0.25\""), std::string::npos) << svg;
}

TEST(Charts, RowsAreNamedForReadOuts) {
  Chart chart{.rows = {"sah \"bvh8\"", "grid"}};
  chart.series.push_back({.key = "k", .label = "k", .points = {{1, 0}, {2, 1}}});
  EXPECT_NE(inline_svg(chart).find("data-rows=\"[&quot;sah \\&quot;bvh8\\&quot;&quot;,&quot;grid&quot;]\""), std::string::npos);
}

TEST(Charts, EqualLogsGiveEqualFiles) {
  const auto draw = [] {
    std::string all;
    const RunLog log = small_log();
    for (const Figure& figure : file_figures(arrange(log))) all += to_svg(figure);
    return all;
  };
  EXPECT_EQ(draw(), draw());
}

}  // namespace
}  // namespace etendue
