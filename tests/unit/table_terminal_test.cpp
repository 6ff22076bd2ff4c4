// Tables as `run`, `report` and `accel` print them.
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "tests/unit/report_helpers.h"

#include <sstream>

namespace etendue {
namespace {

using namespace report_test;

TEST(TerminalTables, EveryGroupOfStructuresFitsATerminal) {
  RunLog log;
  log.structures.push_back(structure("room", "median-round-robin", "bvh16", 0.1234, 12.34));
  StructureRecord& record = log.structures.back();
  record.build_s = record.parallel_build_s = {59.9, 50, 70};
  for (const RayKind kind : ray_kinds)
    record.speed(kind) = record.batched_mrays_per_s[index_of(kind)] = record.to_embree[index_of(kind)] =
        record.to_robust_embree[index_of(kind)] = {0.01234, 0.01, 0.02};
  record.checked = 12'345'678;
  Table table = structures_table(arrange(log));
  table.columns[0].audience = Audience::machines;  // the heading names the scene
  ASSERT_EQ(table.group_titles.size(), 6u);
  for (std::size_t group = 1; group <= 6; ++group) {
    std::istringstream lines(to_terminal(table, group));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 100u) << line;
  }
}

TEST(TerminalTables, WhatIsTooWideForATerminalIsSaidOnceOrBroken) {
  Table table{"t", "T", {{"i", "integrator", false}, {"seeds", "seeds of each configuration"}, {"e", "error", true}},
              {},  {},  {}};
  const std::string common = " photons=200k side_test=false structure=sorted-grid emission=visibility edges=hull";
  const auto row = [&](const std::string& name, double error) { table.rows.push_back({name, 3, error}); };
  row("photon-map" + common + " k=50", 0.5);
  row("sppm k=8" + common + " radius=0.25 neighbours=16 alpha=0.7 kernel=epanechnikov max_depth=12 roulette_depth=7", 0.25);
  const std::string text = to_terminal(table, 0);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 100u) << line;
  EXPECT_NE(text.find("in all rows: seeds of each configuration 3, photons=200k, side_test=false"), std::string::npos) << text;
  EXPECT_NE(text.find("  photon-map k=50  "), std::string::npos) << text;
  EXPECT_NE(text.find("\n    roulette_depth=7\n"), std::string::npos) << text;
  EXPECT_EQ(to_markdown(table).find("in all rows"), std::string::npos);
  table.rows.pop_back();
  table.rows.front().front() = "photon-map";
  EXPECT_EQ(to_terminal(table, 0),
            "  integrator  seeds of each configuration  error\n  photon-map                            3  0.500\n");
}

TEST(TerminalTables, EveryTextColumnIsMadeNarrowerOnATerminal) {
  Table table{"t", "T", {{"a", "a name", false}, {"b", "what it says", false}, {"e", "error", true}}, {}, {}, {}};
  const std::string word(60, 'x');  // which stays the widest, as it cannot be broken
  table.rows.push_back({word, "some words that take more than forty columns", "1"});
  EXPECT_EQ(to_terminal(table, 0), "  a name" + std::string(56, ' ') + "what it says                   error\n  " + word +
                                       "  some words that take more          1\n" + std::string(66, ' ') +
                                       "than forty columns\n");
}

TEST(TerminalTables, ReadersSeeNoColumnThatNoRowFills) {
  Table table{"t", "T", {{"a", "a"}, {"b", "b"}, {"c", "c"}}, {{1, TableCell(), TableCell()}, {2, TableCell(), 3}}, {}, {}};
  EXPECT_EQ(visible_columns(table), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(to_csv(table), "a,b,c\n1,,\n2,,3\n");
  table.rows.clear();
  EXPECT_EQ(visible_columns(table).size(), 3u);
}

// A table like that of experiments/hessian.toml: no column can give up its one-word names and figures.
TEST(TerminalTables, WhatFitsATerminalByNoMeansHasABlockForEachRow) {
  Table table{"t",
              "T",
              {{"", "scene", false},
               {"", "region", false},
               {"", "method", false},
               {"", "RMSE (95 %)", true},
               {"", "over", false},
               {"", "ratio (95 %)", true},
               {"", "side of 1 as expected", false},
               {"", "seeds", true},
               {"", "source", false}},
              {},
              {},
              {}};
  const auto row = [&](std::initializer_list<const char*> texts) {
    table.rows.emplace_back();
    for (const char* text : texts) table.rows.back().push_back(text);
  };
  row({"hessian-shade.pbrt", "whole image", "metric=radiometric-hessian records=1000", "0.0397 (0.0282–0.0525)",
       "metric=occlusion-hessian records=1000", "9.46 (8.95–11.1)", "yes", "3", "[Schwarzhaupt2012] figure 1"});
  row({"hessian-open.pbrt", "whole image", "metric=bounded-split-sphere records=1000", "4.06e-3 (3.31e-3–4.54e-3)",
       "metric=occlusion-hessian records=500", "0.952 (0.735–1.30)", "–", "3", "–"});
  const std::string text = to_terminal(table, 0);
  EXPECT_EQ(text,
            "  in all rows: region whole image, seeds 3, method records=1000, over metric=occlusion-hessian\n"
            "  scene: hessian-shade.pbrt\n"
            "    method: metric=radiometric-hessian\n"
            "    RMSE (95 %): 0.0397 (0.0282–0.0525)\n"
            "    over: records=1000\n"
            "    ratio (95 %): 9.46 (8.95–11.1)\n"
            "    side of 1 as expected: yes\n"
            "    source: [Schwarzhaupt2012] figure 1\n"
            "  scene: hessian-open.pbrt\n"
            "    method: metric=bounded-split-sphere\n"
            "    RMSE (95 %): 4.06e-3 (3.31e-3–4.54e-3)\n"
            "    over: records=500\n"
            "    ratio (95 %): 0.952 (0.735–1.30)\n"
            "    side of 1 as expected: –\n"
            "    source: –\n");
  EXPECT_EQ(wrapped(text, 100), text);
}

}  // namespace
}  // namespace etendue
