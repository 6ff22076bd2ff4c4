// The failure map: its TOML, and runs of it.
#include "experiments/config/cells.h"
#include "experiments/kind.h"
#include "experiments/kinds/stress/stress_config.h"
#include "experiments/kinds/stress/stress_report.h"
#include "tests/places.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/kind_records.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

const std::string stress_experiment =
    "title = \"One hazard\"\n"
    "seeds = 2\n"
    "resolution = [8, 8]\n"
    "budget = { samples = 1 }\n"
    "sweep = { factor = 1.1, samples = { bdpt = 2 } }\n"
    "integrators = [\"path\", \"bdpt\", { name = \"photon-map\", k = 0 }]\n"
    "[[stress]]\n"
    "id = 3\n"
    "name = \"thin <plate>\"\n"
    "failure = \"light leaks\"\n"
    "source = \"1 - (t/r)^2\"\n"
    "scene = \"builtin:thin-plate?thickness={x}\"\n"
    "x = \"thickness\"\n"
    "unit = \"m\"\n"
    "range = [0.2, 0.05]\n"
    "holds = { middle = [0, 2] }\n"
    "settings = { photon-map = { radius = 0.1, kernel = \"box\", caustic_photons = \"20k\", side_test = false } }\n"
    "inapplicable = { path = \"it finds no sun through a veil\" }\n"
    "expect = { photon-map = [0.09, 0.1] }\n"
    "[[stress.remedies]]\n"
    "of = \"photon-map\"\n"
    "name = \"side test\"\n"
    "change = { side_test = true }\n";

std::string stress_with(const std::string& from, const std::string& to) { return replaced(stress_experiment, from, to); }

TEST(StressConfig, TrialsAreMethodsAndRemedies) {
  const ExperimentConfig config = parse_experiment(stress_experiment, "x.toml");
  const auto& hazards = choice_of<StressChoice>(config).hazards;
  ASSERT_EQ(hazards.size(), 1u);
  const auto& trials = hazards[0].trials;
  ASSERT_EQ(trials.size(), 4u);
  EXPECT_FALSE(trials[0].inapplicable.empty());
  EXPECT_EQ(trials[1].samples, 2u);
  EXPECT_EQ(method_at(hazards[0], trials[2], 0.1).label(),
            "photon-map caustic_photons=20000 k=0 kernel=box radius=0.1 side_test=false");
  EXPECT_NE(method_at(hazards[0], trials[3], 0.1).label().find("side_test=true"), std::string::npos);
  EXPECT_EQ(config.kind->resolved(config).size(), 3u) << "of what is rendered";
  const std::vector<Cell> cells = make_cells(config);
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[3].name.key(), "builtin:thin-plate?thickness=0.2 | stress-03 | photon-map: side test | seed=1");
}

TEST(StressConfig, WhatIsMissingIsNamed) {
  for (const char* key : {"id", "name", "failure", "source", "x", "scene"}) {
    const std::string missing = config_error(replaced(stress_experiment, "\n" + std::string(key) + " =", "\nkey_less ="));
    EXPECT_NE(missing.find("no " + std::string(key)), std::string::npos) << key << ": " << missing;
  }
}

TEST(StressConfig, TheParameterMayBeAMethods) {
  const ExperimentConfig config =
      parse_experiment(replaced(stress_with("radius = 0.1", "radius = \"{x}\""), "thickness={x}", "thickness=0.1"), "x.toml");
  const auto& hazard = choice_of<StressChoice>(config).hazards[0];
  EXPECT_NE(method_at(hazard, hazard.trials[2], 0.125).label().find("radius=0.125"), std::string::npos);
}

// The hazard with a second parameter: no remedies, one method, and {y} in its settings.
const std::string two_parameters =
    replaced(replaced(replaced(stress_experiment.substr(0, stress_experiment.find("[[stress.remedies]]")), "radius = 0.1",
                               "radius = \"{y}\""),
                      "inapplicable = { path = \"it finds no sun through a veil\" }\n", ""),
             "expect = { photon-map = [0.09, 0.1] }",
             "rows = { of = \"photon-map\", y = \"radius\", unit = \"m\", values = [0.08, 0.1], expect = [0.0774, 0.0968] }");

TEST(StressConfig, RowsAreSweepsAtValuesOfASecondParameter) {
  const ExperimentConfig config = parse_experiment(two_parameters, "x.toml");
  const auto& hazard = choice_of<StressChoice>(config).hazards[0];
  ASSERT_EQ(hazard.trials.size(), 2u);
  EXPECT_EQ(hazard.trials[0].y, 0.08);
  EXPECT_EQ(hazard.trials[1].expected, (Expected{0.0968, 0.0968}));
  EXPECT_NE(method_at(hazard, hazard.trials[0], 0.1).label().find("radius=0.08"), std::string::npos);
  EXPECT_EQ(make_cells(config)[1].name.key(), "builtin:thin-plate?thickness=0.2 | stress-03 | photon-map: y=0.1 | seed=1");
  // It may be a scene's, and a whole number where it is one.
  const std::string many_lamps = replaced(replaced(two_parameters, "thin-plate?thickness={x}", "many-lamps?lamps={y}"),
                                          "radius = \"{y}\"", "radius = \"{x}\", k = \"{y}\"");
  const ExperimentConfig lamps = parse_experiment(replaced(many_lamps, "[0.08, 0.1]", "[3, 8]"), "x.toml");
  const auto& many = choice_of<StressChoice>(lamps).hazards[0];
  EXPECT_EQ(many.trials[1].scene, "builtin:many-lamps?lamps=8");
  EXPECT_NE(method_at(many, many.trials[1], 0.1).label().find("k=8"), std::string::npos);
}

TEST(StressConfig, SlipsOfRowsAreErrorsAtTheirPlace) {
  const auto slip = [](const std::string& from, const std::string& to) {
    return config_error(replaced(two_parameters, from, to));
  };
  EXPECT_NE(slip("[0.08, 0.1]", "[0.1, 0.08]").find("ascend"), std::string::npos);
  EXPECT_NE(slip("[0.08, 0.1]", "[0.1]").find("2 numbers"), std::string::npos);
  EXPECT_NE(slip("[0.0774, 0.0968]", "[0.0774]").find("expect"), std::string::npos);
  EXPECT_NE(slip("of = \"photon-map\"", "of = \"photon-mop\"").find("photon-map"), std::string::npos);
  EXPECT_NE(slip("radius = \"{y}\"", "radius = 0.1").find("{y} stands nowhere"), std::string::npos);
  EXPECT_NE(slip("middle = [0, 2] }", "work = [0, 2] }\nstructures = [\"sah\"]").find("no maps of structures"),
            std::string::npos);
  EXPECT_NE(slip("rows = { of", "samples = { path = 3 }\nrows = { of").find("path"), std::string::npos) << "it is of no use";
  EXPECT_NE(config_error(stress_with("thickness={x}", "thickness={y}")).find("expected [stress.rows] beside it"),
            std::string::npos);
}

TEST(StressConfig, SlipsAreErrorsAtTheirPlace) {
  const std::string remedy_again = stress_experiment.substr(stress_experiment.find("[[stress.remedies]]"));
  const struct {
    std::string text, where, what;
  } slips[] = {{stress_with("{ middle", "{ midle"), "x.toml:16:", "middle"},
               {stress_with("thin-plate?", "thin-plat?"), "x.toml:12:", "thin-plate"},
               {stress_with("range = [0.2, 0.05]", "range = [0.2, 0.00001]"), "x.toml:12:", "thickness"},
               {stress_with("range = [0.2, 0.05]", "range = [0.2, 0.2]"), "x.toml:15:", "differ"},
               {stress_with("range = [0.2, 0.05]", "range = [0.2]"), "x.toml:15:", "[harmless, harmful]"},
               {stress_with("change = { side_test", "change = { sidetest"), "x.toml:23:", "side_test"},
               {stress_with("of = \"photon-map\"", "of = \"photon-mop\""), "x.toml:21:", "photon-mop"},
               {stress_with("of = \"photon-map\"", "of = \"path\""), "x.toml:21:", "applies to"},
               {stress_with("settings = { photon-map", "settings = { photon-mop"), "x.toml:17:", "photon-map"},
               {stress_with("expect = { photon-map", "expect = { photon-mop"), "x.toml:19:", "photon-map"},
               {stress_with("samples = 1 }", "time = \"1s\" }"), "x.toml:7:", "samples"},
               {stress_with("seeds = 2", "scenes = [\"builtin:edge\"]"), "x.toml:2:", "scenes"},
               {stress_with("seeds = 2", "elsewhere = []"), "x.toml:2:", "of no use"},
               {stress_with("seeds = 2", "reference = { file = \"" + std::string(project_folder) + "README.md\" }"),
                "x.toml:2:", "a scene for each x"},
               {stress_with("integrators = ", "# "), "x.toml:7:", "integrators"},
               {stress_experiment + remedy_again, "x.toml:24:", "twice"},
               {stress_with("factor = 1.1", "factor = 1"), "x.toml:5:", "factor"}};
  for (const auto& slip : slips) {
    const std::string what = config_error(slip.text);
    EXPECT_NE(what.find(slip.where), std::string::npos) << what;
    EXPECT_NE(what.find(slip.what), std::string::npos) << what;
  }
}

TEST(StressExperiment, HasSixteenHazardsTenMethodsAndEightPredictions) {
  const ExperimentConfig config = load_config(std::string(project_folder) + "experiments/stress.toml");
  const auto& hazards = choice_of<StressChoice>(config).hazards;
  EXPECT_GE(hazards.size(), 16u);
  std::size_t expected = 0;
  for (const StressHazard& hazard : hazards) {
    EXPECT_GE(hazard.trials.size(), hazard.of_structures() ? 4u : hazard.second.empty() ? 10u : 6u) << hazard.id;
    for (const StressTrial& trial : hazard.trials) {
      expected += trial.expected.has_value() && !trial.y;
      if (trial.remedy.empty()) continue;
      const auto without = std::ranges::find(hazard.trials, trial.method, &StressTrial::method);
      EXPECT_NE(method_at(hazard, trial, hazard.range.from).label(), method_at(hazard, *without, hazard.range.from).label())
          << hazard.id << ": a remedy that changes nothing";
    }
  }
  EXPECT_GE(expected, 8u);
}

class StressRun : public ProgramTest {};

TEST_F(StressRun, WritesMatrixPicturesAndPageAndResumes) {
  write_file("one.toml", stress_experiment);
  const Outcome first = run({"run", "one.toml", "--threads", "1"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.out.find("expected 0.0900–0.100: confirmed"), std::string::npos) << first.out;
  EXPECT_TRUE(std::filesystem::exists(directory_ / "out/one/pictures/stress-03-photon-map.png"));
  EXPECT_TRUE(std::filesystem::exists(directory_ / "out/one/charts/matrix.svg"));
  EXPECT_NE(read_text_file(directory_ / "out/one/report.html").find("data:image/png;base64"), std::string::npos);
  const std::string table = read_text_file(directory_ / "out/one/tables/thresholds.md");
  EXPECT_NE(table.find("does not apply: it finds no sun"), std::string::npos) << table;
  const Outcome again = run({"run", "one.toml", "--threads", "1"});
  EXPECT_NE(again.err.find("4 of 4 cells are done already"), std::string::npos) << again.err;
  EXPECT_EQ(read_text_file(directory_ / "out/one/tables/thresholds.md"), table);
  const Outcome report = run({"report", "out/one", "--latex"});
  EXPECT_EQ(report.status, 0) << report.err;
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out/one/latex/matrix.tex"));  // which is drawn, not charted
}

TEST_F(StressRun, AReferenceThatIsAnotherTakesWhatItMeasuredOutOfTheLog) {
  write_file(
      "one.toml",
      "seeds = 1\nresolution = [8, 8]\nbudget = { samples = 1 }\nreference = { file = \"ref.exr\" }\n"
      "integrators = [\"photon-map\", \"sppm\"]\n[[stress]]\nid = 1\nname = \"radius\"\nfailure = \"f\"\n"
      "source = \"s\"\nscene = \"builtin:cornell-box\"\nx = \"radius\"\nrange = [0.1, 0.2]\n"
      "holds = { relmse = [0, 1e9] }\nsettings = { photon-map = { radius = \"{x}\", k = 0 }, sppm = { radius = \"{x}\" } }\n");
  const auto run_with = [&](const std::string& method, const std::string& filter) {
    EXPECT_EQ(run({"render", "builtin:cornell-box", "-i", method, "--spp", "4", "--resolution", "8x8", "-o", "ref.exr"}).status,
              0);
    const Outcome ran = run({"run", "one.toml", "--threads", "1", "--filter", filter});
    EXPECT_EQ(ran.status, 0) << ran.err;
    return ran.err;
  };
  run_with("path", "photon-map");
  const RunLog before = read_log((directory_ / "out/one/runs.jsonl").string());
  const std::vector<std::string> references = records_of<StressRecord>(before).at(0)->references;
  ASSERT_EQ(references.size(), 1u);
  EXPECT_EQ(before.references.size(), 1u);
  EXPECT_NE(run_with("path", "builtin").find("1 of 2 cells are done already"), std::string::npos);
  const std::string again = run_with("bdpt", "builtin");
  EXPECT_NE(again.find("is not the one that its cells were measured against"), std::string::npos) << again;
  EXPECT_EQ(again.find("done already"), std::string::npos) << again;
}

TEST_F(StressRun, CommandsRepeatTheImageWithItsPixelFilter) {
  write_file(
      "one.toml",
      "seeds = 1\nresolution = [8, 8]\nbudget = { samples = 1 }\nreference = { samples = 16 }\nintegrators = [\"sppm\"]\n"
      "[[stress]]\nid = 1\nname = \"radius\"\nfailure = \"f\"\nsource = \"s\"\nscene = \"builtin:cornell-box\"\n"
      "x = \"radius\"\nrange = [0.1, 0.2]\nholds = { relmse = [0, 1e9] }\n"
      "settings = { sppm = { radius = \"{x}\" } }\n");
  const Outcome ran = run({"run", "one.toml", "--threads", "1", "--pixel-filter", "mitchell"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  const std::string command = records_of<StressRecord>(read_log((directory_ / "out/one/runs.jsonl").string())).at(0)->before;
  EXPECT_TRUE(command.ends_with(" --seed 1 --pixel-filter mitchell")) << command;
}

// The lattice begins at six digits of the range's end.
TEST_F(StressRun, StructuresAreMeasuredOverTheHarmlessEndHoweverManyDigitsItHas) {
  for (const char* from : {"1", "1.0000001"})
    write_file(std::string("from-") + from + ".toml",
               "seeds = 1\nbudget = { samples = 1 }\nintegrators = [\"path\"]\n[[stress]]\nid = 1\nname = \"slivers\"\n"
               "failure = \"f\"\nsource = \"s\"\nscene = \"builtin:slivers?aspect={x}\"\nx = \"aspect\"\nrange = [" +
                   std::string(from) + ", 100]\nholds = { work = [0, 4] }\nstructures = [\"binned-sah\"]\n");
  const auto figures = [&](const std::string& name) {
    EXPECT_EQ(run({"run", name + ".toml", "--threads", "1"}).status, 0);
    const std::string table = read_text_file(directory_ / ("out/" + name + "/tables/thresholds.csv"));
    return table.substr(table.find("holds to the end"));
  };
  EXPECT_EQ(figures("from-1.0000001"), figures("from-1"));
}

}  // namespace
}  // namespace etendue
