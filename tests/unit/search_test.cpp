// Experiments on point and record structures: what they read, measure, log and conclude.
#include "experiments/config/config.h"
#include "experiments/kinds/search/measure_search.h"
#include "experiments/kinds/search/search_curves.h"
#include "experiments/kinds/search/search_sets.h"
#include "framework/io/load_scene.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/kind_records.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

SearchRecord record_of(std::uint64_t count, std::initializer_list<std::pair<const char*, double>> times) {
  SearchRecord record;
  record.cell = {"cloud", "points", "count=" + std::to_string(count), 1};
  record.status = "done";
  record.kind = "points";
  record.set = "cloud";
  record.count = count;
  for (const auto& [structure, time] : times)
    record.figures.push_back({structure, "within", 10, {time, 0.9 * time, 1.1 * time}, 10});
  return record;
}

TEST(SearchConfig, ReadsSetsSizesAndStructures) {
  const ExperimentConfig config = parse_experiment(
      "scenes = [\"builtin:cornell-box\"]\n[points]\nstructures = [\"hash-grid\", \"brute\"]\ncounts = [5, \"2k\"]\n"
      "contrasts = [1, 100]\nneighbours = [3]\n",
      "e.toml");
  const auto& choice = choice_of<SearchChoice>(config);
  EXPECT_EQ(choice.structures, (std::vector<std::string>{"hash-grid", "brute"}));
  EXPECT_EQ(choice.counts, (std::vector<std::uint64_t>{5, 2000}));
  const std::vector<SearchSet> sets = search_sets(choice, {"builtin:cornell-box"});
  ASSERT_EQ(sets.size(), 3u);
  EXPECT_EQ(sets[2].label, "clustered contrast=100");
}

TEST(SearchConfig, WhatDoesNotFitIsAnErrorAtItsPlace) {
  expect_error("[points]\nstructures = [\"hash-gird\"]\ncontrasts = [1]\n", "x.toml:2", "hash-grid");
  expect_error("[points]\ncounts = [100, 10]\ncontrasts = [1]\n", "x.toml", "ascending");
  expect_error("[points]\ncontrasts = []\n", "x.toml", "nothing to search");
  expect_error("scenes = [\"builtin:cornell-box\"]\n[records]\nneighbours = [1]\n", "x.toml", "neighbours");
  expect_error("scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\n[records]\n", "x.toml", "of no use");
}

TEST(SearchSets, ASpotIsAsMuchDenserAsAsked) {
  for (const double contrast : {8.0, 200.0}) {
    const PointSet set = clustered_points(contrast, 40000, 100, 1);
    const float side = std::sqrt(2 / static_cast<float>(contrast)), low = 0.3f * (1 - side);
    const auto on_spot = std::count_if(set.points.begin(), set.points.end(), [&](const vec3& p) {
      return p.y == 0 && p.x >= low && p.x < low + side && p.z >= low && p.z < low + side;
    });
    const double area = side * side, density = static_cast<double>(on_spot) / area;
    const double rest = (40000.0 - static_cast<double>(on_spot)) / (2 - area);
    EXPECT_NEAR(density / rest, contrast + 1, 0.05 * contrast);
    EXPECT_EQ(set.points.size(), 40000u);
  }
}

TEST(SearchSets, RecordsCoverAsManyTimesAsAsked) {
  const Scene scene = load_scene("builtin:cornell-box", {});
  for (const double spread : {1.0, 100.0}) {
    const RecordSet set = records_of_scene(scene, spread, 6, 2000, 400, 3);
    const auto [low, high] = std::minmax_element(set.radii.begin(), set.radii.end());
    EXPECT_NEAR(*high / *low, spread, 0.05 * spread);
    double covering = 0;
    for (const vec3& p : set.queries)
      for (std::size_t i = 0; i < set.radii.size(); ++i) covering += glm::length(p - set.centres[i]) <= set.radii[i];
    EXPECT_NEAR(covering / static_cast<double>(set.queries.size()), 6, 1.5);
  }
}

TEST(SearchMeasurement, StructuresAgreeAndEveryFigureIsThere) {
  const Scene scene = load_scene("builtin:cornell-box", {});
  for (const bool records : {false, true}) {
    SearchChoice choice;
    choice.records = records;
    choice.structures = {"brute", "hash-grid", "bvh"};
    choice.neighbours = {1, 10};
    choice.queries = 50;
    choice.repetitions = 1;
    const SearchSet set{"scene", "scene", 0, records ? "spread" : "", records ? 4.0 : 0.0};
    SearchRecord record = measure_search({choice, set, &scene, 300, 1});
    EXPECT_EQ(record.disagreements, 0u);
    EXPECT_GT(record.checked, 50u);
    EXPECT_EQ(record.figures.size(), 3u * (records ? 3 : 6));
    for (const SearchFigure& f : record.figures) {
      const bool nothing_kept = f.measure == "memory" && f.structure == "brute" && !records;
      EXPECT_EQ(f.value.median > 0, !nothing_kept) << f.structure << " " << f.measure;
      if (f.measure == "nearest") {
        EXPECT_EQ(f.found, f.parameter);
      }
    }
    record.cell = {"scene", "points", "count=300", 1};
    record.status = "done";
    EXPECT_EQ(read_back<SearchRecord>(record.line()).line(), record.line());
  }
}

// Queries of one place follow each other, and a slow structure answers a part of them.
TEST(SearchMeasurement, ASlowStructureIsAskedAllOverTheScene) {
  const Scene scene = load_scene("builtin:cornell-box", {});
  SearchChoice choice;
  choice.structures = {"brute", "hash-grid"};
  choice.neighbours = {50};
  choice.queries = 2000;
  choice.repetitions = 1;
  const SearchRecord record = measure_search({choice, {"scene", "scene", 0, "", 0}, &scene, 100'000, 1});
  std::vector<double> found;
  for (const SearchFigure& f : record.figures)
    if (f.measure == "within") found.push_back(f.found);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0] / found[1], 1, 0.5);
}

TEST(SearchCurves, CrossoversLieWhereLogarithmsMeet) {
  RunLog log;
  add_record(log, record_of(10, {{"brute", 1}, {"tree", 10}, {"grid", 40}}));
  add_record(log, record_of(1000, {{"brute", 100}, {"tree", 10}, {"grid", 30}}));
  add_record(log, record_of(100000, {{"brute", 1e4}, {"tree", 50}, {"grid", 20}}));
  const std::vector<SearchPlot> plots = search_plots(log);
  ASSERT_FALSE(plots.empty());
  ASSERT_EQ(plots[0].abscissa, "count");
  const std::vector<Crossover> found = crossovers(plots[0]);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].overtaking, "tree");
  EXPECT_NEAR(found[0].at, 100, 1e-6);
  EXPECT_TRUE(found[0].lead && found[0].clear);
  EXPECT_EQ(found[1].overtaking, "grid");  // brute force alone: the tree leads already
  EXPECT_FALSE(found[1].lead);
  EXPECT_EQ(found[2].overtaken, "tree");
  EXPECT_TRUE(found[2].lead);
  EXPECT_EQ(search_crossovers_table(log).rows.size(), 3u);
  EXPECT_EQ(plots[0].curves[*leader_at(plots[0], 100000)].structure, "grid");
}

TEST(SearchReport, TheAnswerCountsTheSetsOfOtherStructures) {
  RunLog log;
  const char* const fastest[] = {"a", "a", "b", "c", "d", "e"};
  for (std::size_t i = 0; i < std::size(fastest); ++i) {
    SearchRecord& record = add_record(log, record_of(100, {{fastest[i], 1}, {"slow", 2}}));
    record.cell.scene = record.set = "cloud " + std::to_string(i);
  }
  EXPECT_EQ(search_report(log).answer,
            "Fastest at the largest number: within: a in 2 of 6, b in 1, c in 1, others in 2; beyond the spread in 6 of 6");
  EXPECT_EQ(search_report(log).tables.at(1).rows.at(0).back().raw, "yes");
  add_record(log, record_of(100, {{"a", 1}, {"slow", 1.05}}));  // a tenth about either
  EXPECT_NE(search_report(log).answer.find("beyond the spread in 6 of 7"), std::string::npos) << search_report(log).answer;
}

TEST(SearchReport, RowsOfSeveralSeedsSayWhose) {
  RunLog log;
  add_record(log, record_of(100, {{"tree", 1}}));
  const auto columns = [&] {
    const Table times = search_report(log).tables.at(0);
    return std::pair(visible_columns(times).size(), times.rows.back()[column_of(times, "seed").value()].raw);
  };
  const auto [of_one, first] = columns();
  EXPECT_EQ(first, "1");
  add_record(log, record_of(100, {{"tree", 2}})).cell.seed = 2;
  EXPECT_EQ(columns(), std::pair(of_one + 1, std::string("2")));
}

// It appends to a list, which no structure can beat.
TEST(SearchReport, BruteForceIsNotTheFastestToInsertInto) {
  RunLog log;
  SearchRecord& record = add_record(log, record_of(100, {{"brute", 1}, {"tree", 20}, {"grid", 30}}));
  for (SearchFigure& figure : record.figures) figure.measure = "insert", figure.parameter = 0;
  const Table leaders = search_report(log).tables.at(1);
  ASSERT_EQ(leaders.rows.size(), 1u);
  EXPECT_EQ(leaders.rows[0][column_of(leaders, "fastest").value()].raw, "tree");
  EXPECT_NE(search_report(log).answer.find("insert: tree in 1 of 1"), std::string::npos) << search_report(log).answer;
}

}  // namespace
}  // namespace etendue
