// The catalogue of failures: its figures, its verdicts, and the way from its TOML to its report.
#include "experiments/config/cells.h"
#include "experiments/kinds/claims/claims_report.h"
#include "experiments/kinds/stress/stress_config.h"
#include "experiments/kinds/stress/stress_report.h"
#include "tests/places.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/kind_records.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

StressRecord record_of(std::vector<double> medians, double low = 0, double high = 0.1) {
  StressRecord record;
  record.cell = {"builtin:edge", "darkest", "stress-01", 1};
  record.status = "done";
  record.id = 1;
  record.claim = "it <fails>";
  record.claimed = "relmse";
  record.holds = {low, high};
  for (std::size_t i = 0; i < medians.size(); ++i) {
    record.figures.push_back({i == 0 ? "as it is" : "remedy " + std::to_string(i),
                              "relmse",
                              FigureKind::plain,
                              {medians[i], medians[i], medians[i]},
                              true,
                              i == 0 ? Expected{1, endless} : record.holds});
    record.methods.push_back("path");
  }
  return record;
}

std::vector<Verdict> verdicts_on(const StressRecord& record) {
  std::vector<Verdict> verdicts;
  for (const JudgedPrediction& row : judge_stress(record)) verdicts.push_back(*row.verdict);
  return verdicts;
}

TEST(StressVerdicts, FollowTheIntervals) {
  using enum Verdict;
  EXPECT_EQ(verdicts_on(record_of({2, 0.05, 1, 1.9})), (std::vector{confirmed, confirmed, weaker, refuted}));
  EXPECT_EQ(verdicts_on(record_of({0.5})), (std::vector{weaker})) << "it fails, but by less";
  EXPECT_EQ(verdicts_on(record_of({0.05, 0.2})), (std::vector{refuted, refuted})) << "a remedy that breaks what was sound";
}

TEST(StressFigures, AreWhatTheySay) {
  Image reference({20, 10}), image({20, 10});
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    reference.pixels[i] = dvec3(i < 100 ? 0.0 : 2.0);
    image.pixels[i] = dvec3(i < 100 ? 7.0 : i < 110 ? 1.0 : 2.0);
  }
  const auto figure = [&](const char* name) { return find_stress_figure(name, {}).compute(image, reference); };
  EXPECT_EQ(figure("darkest"), 0.5) << "pixels without light have no ratio";
  EXPECT_EQ(figure("middle"), 1);
  EXPECT_EQ(figure("brightest"), 1);
  EXPECT_EQ(figure("blotches"), 0.5);
  EXPECT_THROW(find_stress_figure("darker", {}), Error);
}

const std::string experiment =
    "title = \"One failure\"\n"
    "seeds = 2\n"
    "resolution = [16, 16]\n"
    "budget = { samples = 2 }\n"
    "[[stress]]\n"
    "id = 3\n"
    "failure = \"leaks\"\n"
    "source = \"theory\"\n"
    "scene = \"builtin:thin-plate?thickness=0.05\"\n"
    "figure = \"middle\"\n"
    "method = { name = \"photon-map\", k = 0, radius = 0.1, kernel = \"box\", caustic_photons = \"50k\", side_test = false }\n"
    "expect = { fails = [12, 14], holds = [0.98, 1.02] }\n"
    "[[stress.remedies]]\n"
    "name = \"side test\"\n"
    "change = { side_test = true }\n";

std::string with(const std::string& from, const std::string& to) { return replaced(experiment, from, to); }

TEST(StressConfig, ChangesAreOfTheMethod) {
  const ExperimentConfig config = parse_experiment(experiment, "x.toml");
  const auto& rows = choice_of<StressChoice>(config).rows;
  ASSERT_EQ(rows.size(), 1u);
  ASSERT_EQ(rows[0].trials.size(), 2u);
  const Method& remedied = rows[0].trials[1].method;
  EXPECT_EQ(remedied.name, "photon-map");
  EXPECT_NE(remedied.label().find("side_test=true"), std::string::npos);
  EXPECT_NE(remedied.label().find("radius=0.1"), std::string::npos);
  const std::vector<Cell> cells = make_cells(config);
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_EQ(cells[0].name.key(), "builtin:thin-plate?thickness=0.05 | middle | stress-03 | seed=1");
}

TEST(StressConfig, SlipsAreErrorsAtTheirPlace) {
  const struct {
    std::string text, where, what;
  } slips[] = {
      {with("\"middle\"", "\"midle\""), "x.toml:10:", "middle"},
      {with("thin-plate?", "thin-plat?"), "x.toml:9:", "thin-plate"},
      {with("change = { side_test", "change = { sidetest"), "x.toml:15:", "side_test"},
      {with("fails = [12, 14]", "fails = [1, 14]"), "x.toml:12:", "overlap"},
      {with("fails = [12, 14], ", ""), "x.toml:12:", "fails = [low, high], holds"},
      {with("expect = { fails = [12, 14], ", "fails = [12, 14]\nexpect = { "), "x.toml:12:1: fails: spelt otherwise", "expect"},
      {with("change = { side_test = true", "change = { side_test = [true, false]"),
       "x.toml:15:", "an array; expected a single value"},
      {with("samples = 2", "time = \"1s\""), "x.toml:5:", "samples"},
      {with("seeds = 2", "scenes = [\"builtin:edge\"]"), "x.toml:2:", "scenes"}};
  for (const auto& slip : slips) {
    const std::string what = config_error(slip.text);
    EXPECT_NE(what.find(slip.where), std::string::npos) << what;
    EXPECT_NE(what.find(slip.what), std::string::npos) << what;
  }
}

TEST(StressExperiment, IsValidAndItsRemediesAreNamedApart) {
  const ExperimentConfig config = load_config(std::string(project_folder) + "experiments/stress.toml");
  const auto& rows = choice_of<StressChoice>(config).rows;
  EXPECT_GE(rows.size(), 10u);
  for (const StressRow& row : rows)
    for (std::size_t i = 1; i < row.trials.size(); ++i)
      EXPECT_NE(row.trials[i].method.label(), row.trials[0].method.label()) << row.id << ": a remedy that changes nothing";
}

TEST(StressRecord, LineIsReadBack) {
  const StressRecord record = record_of({2, 0.05}, -endless, 0.1);
  const auto read = read_back<StressRecord>(record.line());
  EXPECT_EQ(read.holds.low, -endless);
  EXPECT_EQ(verdicts_on(read), verdicts_on(record));
  EXPECT_EQ(read.line(), record.line());
}

TEST(StressReport, StandsApartFromClaims) {
  RunLog log;
  add_record(log, record_of({2, 0.05}));
  EXPECT_EQ(stress_report(log).predictions.rows.size(), 2u);
  EXPECT_NE(stress_report(log).section.find("it &lt;fails&gt;"), std::string::npos);
  EXPECT_TRUE(claims_table(log).rows.empty());
  EXPECT_TRUE(claims_report(log).section.empty());
}

TEST(StressReport, FiguresStandBelowANameThatATerminalDoesNotHoldBesideThem) {
  RunLog log;
  const std::string name(60, 'x');
  add_record(log, record_of({2, 0.05})).figures[1].quantity = name;
  EXPECT_EQ(stress_summary(log),
            " 1  it <fails>  (builtin:edge: relmse)\n"
            "      as it is\n        2.00                     expected above 1.00     confirmed\n"
            "      " +
                name + "\n        0.0500                   expected 0–0.100        confirmed\n");
}

class StressRun : public ProgramTest {};

TEST_F(StressRun, WritesTablePicturesAndPageAndResumes) {
  write_file("one.toml", experiment);
  const Outcome first = run({"run", "one.toml", "--threads", "1"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.out.find("expected 12.0–14.0"), std::string::npos) << first.out;
  EXPECT_EQ(first.out.find("refuted"), std::string::npos) << first.out;
  EXPECT_TRUE(std::filesystem::exists(directory_ / "out/one/pictures/stress-03.png"));
  EXPECT_NE(read_text_file(directory_ / "out/one/report.html").find("data:image/png;base64"), std::string::npos);
  const std::string table = read_text_file(directory_ / "out/one/tables/predictions.md");
  const Outcome again = run({"run", "one.toml", "--threads", "1"});
  EXPECT_NE(again.err.find("1 of 1 cells are done already"), std::string::npos) << again.err;
  EXPECT_EQ(read_text_file(directory_ / "out/one/tables/predictions.md"), table);
}

}  // namespace
}  // namespace etendue
