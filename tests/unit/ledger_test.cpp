// The ledger: the verdict on a decision, what rows may say, and runs of components where a scene does and does not need them.
#include "experiments/kinds/ledger/ledger.h"
#include "experiments/kind.h"
#include "experiments/kinds/second_level.h"
#include "experiments/run/run_cell.h"
#include "framework/io/image/exr.h"
#include "framework/io/load_scene.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/silent_observer.h"

#include <unistd.h>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace etendue {
namespace {

// Eight seeds whose ratios of error and time scatter by 1 % about those given.
LedgerRecord record_of(double error_ratio, double time_ratio, const std::string& bias = "unbiased", double exponent = -1) {
  LedgerRecord record;
  record.cell = {"builtin:box", "path", "part", 1};
  record.status = "done";
  record.bias = bias;
  record.mse_exponent = exponent;
  for (std::uint64_t i = 0; i < 8; ++i) {
    const double scatter = std::exp(i % 2 == 0 ? 0.01 : -0.01);
    record.trials.push_back({i + 1, 1e-3, 1e-3 * error_ratio * scatter, 2, 2 * time_ratio * scatter, false});
  }
  return record;
}

TEST(LedgerVerdict, TimeToTheSameErrorDecides) {
  EXPECT_EQ(judge_decision(record_of(1.5, 1), 500), LedgerVerdict::earns_its_time);
  EXPECT_EQ(judge_decision(record_of(1, 1.3), 500), LedgerVerdict::earns_its_time);
  EXPECT_EQ(judge_decision(record_of(2, 0.8), 500), LedgerVerdict::earns_its_time) << "it costs time and saves more";
  EXPECT_EQ(judge_decision(record_of(1, 0.8), 500), LedgerVerdict::contradicted);
  EXPECT_EQ(judge_decision(record_of(0.5, 1.2), 500), LedgerVerdict::contradicted);
  EXPECT_EQ(judge_decision(record_of(1, 1.005), 500), LedgerVerdict::costs_nothing);
}

TEST(LedgerVerdict, NoiseAndFewSeedsDecideNothing) {
  LedgerRecord noisy = record_of(1.3, 1);
  for (std::size_t i = 0; i < noisy.trials.size(); ++i) noisy.trials[i].switched_error *= i % 2 == 0 ? 3 : 1.0 / 3;
  EXPECT_EQ(judge_decision(noisy, 1), LedgerVerdict::no_gain);
  LedgerRecord few = record_of(2, 2);
  few.trials.resize(2);
  EXPECT_EQ(judge_decision(few, 1), LedgerVerdict::no_gain);
}

TEST(LedgerVerdict, MoreDecisionsAskForMore) {
  LedgerRecord record = record_of(1.1, 1);
  for (std::size_t i = 0; i < record.trials.size(); ++i) record.trials[i].switched_error *= i % 4 < 2 ? 1.1 : 1 / 1.1;
  EXPECT_EQ(judge_decision(record, 1), LedgerVerdict::earns_its_time);
  EXPECT_EQ(judge_decision(record, 1000), LedgerVerdict::no_gain);
}

TEST(LedgerVerdict, BiasIsNotTradedForTime) {
  EXPECT_EQ(judge_decision(record_of(4, 0.1, "biased"), 500), LedgerVerdict::trade);
  EXPECT_EQ(judge_decision(record_of(0.25, 10, "biased"), 500), LedgerVerdict::trade);
  EXPECT_EQ(judge_decision(record_of(0.5, 0.5, "biased"), 500), LedgerVerdict::contradicted) << "better in both";
  EXPECT_EQ(judge_decision(record_of(1.5, 1, "biased"), 500), LedgerVerdict::earns_its_time);
}

TEST(LedgerVerdict, TheMethodsExponentTurnsErrorIntoTime) {
  const LedgerRecord record = record_of(1.2, 0.8, "consistent", -0.5);
  EXPECT_NEAR(ledger_figures(record).time_to_error.centre, 1.2 * 1.2 * 0.8, 1e-9);
  EXPECT_EQ(judge_decision(record, 500), LedgerVerdict::earns_its_time);
  EXPECT_EQ(verdict_name(judge_decision(record_of(1.2, 0.8), 500)), "no gain beyond noise") << "though both differ";
}

TEST(LedgerVerdict, ErrorsOfRoundingAreAlike) {
  LedgerRecord record = record_of(1, 1);
  for (LedgerTrial& trial : record.trials) {
    trial.error = 0;
    trial.switched_error = 1e-14;
  }
  EXPECT_EQ(ledger_figures(record).error.centre, 1);
}

TEST(LedgerVerdict, NoiseOfTheReferenceIsTakenFromErrors) {
  LedgerRecord record = record_of(1.4, 1);
  record.relmse_floor = 1e-2;
  for (LedgerTrial& trial : record.trials) {
    trial.error += record.relmse_floor;
    trial.switched_error += record.relmse_floor;
  }
  EXPECT_NEAR(ledger_figures(record).error.centre, 1.4, 1e-9);
  record.relmse_floor = 1;
  EXPECT_EQ(ledger_figures(record).error.centre, 1) << "a tenth of the noise is left";
  record.relmse_floor = 0;
  EXPECT_LT(ledger_figures(record).error.centre, 1.05) << "as of older lines";
}

// With the noise the ratio is 1.07; without it both errors are at their least, and the ratio is 1.
TEST(LedgerVerdict, ErrorsThatAreMostlyTheReferencesNoiseDecideNothing) {
  LedgerRecord record = record_of(4.5, 1 / 1.2);
  EXPECT_EQ(judge_decision(record, 1), LedgerVerdict::earns_its_time);
  record.relmse_floor = 0.05;
  for (LedgerTrial& trial : record.trials) {
    trial.error += record.relmse_floor;
    trial.switched_error += record.relmse_floor;
  }
  EXPECT_EQ(judge_decision(record, 1), LedgerVerdict::no_gain);
  for (LedgerTrial& trial : record.trials) trial.switched_error = 5;
  EXPECT_EQ(judge_decision(record, 1), LedgerVerdict::earns_its_time) << "the other stands far above the noise";
}

TEST(LedgerReport, TellsWhereTheReferencesNoiseIsNotSmall) {
  const auto notes = [](double floor) {
    RunLog log;
    auto record = std::make_shared<LedgerRecord>(record_of(1.4, 1));
    record->reference = "closed form: 1";
    record->relmse_floor = floor;
    log.records.push_back(record);
    return joined(ledger_report(log).tables.at(0).notes, " ");
  };
  EXPECT_EQ(notes(0).find("noise of"), std::string::npos) << notes(0);
  EXPECT_NE(notes(5e-6).find("noise of rendered references is taken"), std::string::npos) << notes(5e-6);
  EXPECT_EQ(notes(5e-6).find("more than 1 %"), std::string::npos) << notes(5e-6);
  EXPECT_NE(notes(2e-5).find("Of 1 decision the reference's noise is more than 1 % of an error, on builtin:box"),
            std::string::npos)
      << notes(2e-5);
}

TEST(LedgerReport, TellsOfReferencesOfUnknownNoise) {
  const auto notes = [](const std::string& reference) {
    RunLog log;
    auto record = std::make_shared<LedgerRecord>(record_of(1.4, 1));
    record->reference = reference;
    log.records.push_back(record);
    return joined(ledger_report(log).tables.at(0).notes, " ");
  };
  EXPECT_NE(notes("0.9 of path").find("Nobody knows the noise of the references of builtin:box"), std::string::npos);
  EXPECT_EQ(notes("closed form: 1").find("Nobody knows"), std::string::npos);
}

TEST(LedgerReport, TheMedianOfTwoRatiosIsGeometric) {
  RunLog log;
  for (const double ratio : {0.5, 2.0}) {
    log.records.push_back(std::make_shared<LedgerRecord>(record_of(ratio, 1)));
    log.records.back()->cell.scene += std::to_string(ratio);
  }
  const Table table = ledger_report(log).tables.at(0);
  EXPECT_NEAR(table.rows.at(0)[*column_of(table, "error")].order.value(), 1, 1e-9);
}

TEST(LedgerReport, NamesWhatIsContradictedAndWhyItStands) {
  RunLog log;
  for (const auto& [scene, time] : {std::pair("builtin:a", 1.5), std::pair("builtin:b", 0.5)}) {
    auto record = std::make_shared<LedgerRecord>(record_of(1, time));
    record->cell.scene = scene;
    record->kept = "it guards against leaks";
    log.records.push_back(record);
  }
  const KindReport report = ledger_report(log);
  EXPECT_EQ(report.answer, "2 decisions: 1 earns its time, 1 contradicted; contradicted: part of path (b)");
  const Table& table = report.tables.at(0);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][*column_of(table, "contradicted_on")].text, "b (it stands: it guards against leaks)");
  EXPECT_EQ(report.tables.at(1).rows.size(), 2u);
}

TEST(LedgerReport, FindingsTellComponentsOfOneNameApart) {
  RunLog log;
  for (const char* method : {"irradiance-cache", "hash-cache"}) {
    auto record = std::make_shared<LedgerRecord>(record_of(1, 0.5));
    record->cell.accel = method;
    log.records.push_back(record);
  }
  const KindReport report = ledger_report(log);
  ASSERT_EQ(report.findings.size(), 2u);
  EXPECT_EQ(report.findings[0].first, "part, irradiance-cache");
  EXPECT_EQ(report.findings[1].first, "part, hash-cache");
}

const std::string ledger_base =
    "scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\nresolution = [8, 8]\nseeds = 2\n";
const std::string row = "[[ledger]]\ncomponent = \"c\"\non = { mis = \"auto\" }\noff = { mis = \"light\" }\n";

TEST(LedgerConfig, MistakesAreErrorsAtTheirPlaces) {
  EXPECT_EQ(config_error(ledger_base + row), "no error");
  expect_error(ledger_base + replaced(row, "light", "balance2"), "x.toml:8:15", "balance");
  expect_error(ledger_base + replaced(row, "auto", "balance"), "x.toml:5:1", "itself is none of");
  expect_error(ledger_base + replaced(row, "auto", "light"), "x.toml:5:1", "differ");
  expect_error(ledger_base + row + "decided = \"caustic\"\n", "x.toml:9:11", "caustic-map");
  expect_error(ledger_base + row + "method = \"path\"\naccel = \"sah\"\n", "x.toml:5:1", "one of method, accel and edit");
  expect_error(ledger_base + replaced(row, "auto", "balance") + "decide = \"caustic-map\"\n", "x.toml:9:1", "decided");
  expect_error(ledger_base + row + row, "x.toml:9:1", "twice");
  expect_error(replaced(ledger_base, "samples = 1", "time = 1") + row, "x.toml:5:3", "samples = N");
  expect_error("accels = [\"sah\"]\n" + ledger_base + row, "x.toml:1:1", "of no use beside [[ledger]]");
  expect_error(replaced(ledger_base, "samples = 1", "samples = 1, checkpoints = \"log\"") + row, "x.toml:2:25",
               "at the end alone");
}

// By their defaults a run knows whether it goes on with the same experiment.
TEST(LedgerConfig, MethodsOfRowsAreToldWithTheirDefaults) {
  const ExperimentConfig config = parse_experiment(ledger_base + row, "x.toml");
  const std::vector<std::string> texts = config.kind->resolved(config);
  ASSERT_EQ(texts.size(), 4u) << "method, structure, on and off";
  EXPECT_NE(joined(texts, "\n").find("mis=light"), std::string::npos);
  EXPECT_NE(texts[0].find("roulette_depth="), std::string::npos) << texts[0];
}

class LedgerRun : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(directory_); }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  // The records by component.
  std::map<std::string, LedgerRecord> run(const std::string& text) {
    std::ofstream(directory_ / "l.toml") << text;
    RunOptions options;
    options.experiment = (directory_ / "l.toml").string();
    options.out = (directory_ / "out").string();
    SilentObserver observer;
    execute_run(plan_run(options), observer);
    EXPECT_EQ(execute_run(plan_run(options), observer).done, 0u) << "all is resumed";
    const RunLog log = read_log((directory_ / "out/runs.jsonl").string());
    std::map<std::string, LedgerRecord> records;
    for (const LedgerRecord* record : records_of<LedgerRecord>(log)) {
      EXPECT_EQ(record->error, "");
      records[record->cell.integrator] = *record;
    }
    return records;
  }

  const std::filesystem::path directory_ =
      std::filesystem::temp_directory_path() / ("etendue-ledger-" + std::to_string(getpid()));
};

TEST_F(LedgerRun, WhatASceneDoesNotNeedChangesNoBit) {
  const auto records =
      run(replaced(ledger_base, "cornell-box", "lambert-sphere") +
          "[[ledger]]\ncomponent = \"map\"\nmethod = { name = \"photon-map\", photons = 1000, final_gather = 1 }\n"
          "decided = \"caustic-map-of-records\"\non = { caustic_map = \"on\" }\noff = { caustic_map = \"off\" }\n"
          "[[ledger]]\ncomponent = \"tree\"\ndecided = \"light-tree\"\non = { lights = \"tree\" }\n"
          "off = { lights = \"power\" }\n"
          "[[ledger]]\ncomponent = \"level\"\nedit = \"second-level\"\n"
          "[[ledger]]\ncomponent = \"splits\"\naccel = \"binned-sah\"\non = { name = \"sbvh\" }\noff = {}\n");
  ASSERT_EQ(records.size(), 4u);
  for (const auto& [component, record] : records) {
    EXPECT_FALSE(record.on) << component << ": " << record.why;
    ASSERT_EQ(record.trials.size(), 2u);
    for (const LedgerTrial& trial : record.trials) {
      EXPECT_TRUE(trial.same_image) << component;
      EXPECT_EQ(trial.error, trial.switched_error) << component;
      EXPECT_GT(trial.cpu_s, 0);
    }
  }
}

TEST_F(LedgerRun, WhatASceneNeedsChangesItsImage) {
  const auto records =
      run(replaced(ledger_base, "cornell-box", "water") +
          "[[ledger]]\ncomponent = \"map\"\nmethod = { name = \"photon-map\", photons = 1000, final_gather = 1 }\n"
          "decided = \"caustic-map-of-records\"\non = { caustic_map = \"on\" }\noff = { caustic_map = \"off\" }\n");
  EXPECT_TRUE(records.at("map").on);
  EXPECT_EQ(records.at("map").switched, "photon-map caustic_map=off final_gather=1 photons=1000");
  for (const LedgerTrial& trial : records.at("map").trials) EXPECT_FALSE(trial.same_image);
}

// Two components of the same method, whose own image is one and the same.
class LedgerReference : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const std::string both = row + replaced(replaced(row, "\"c\"", "\"d\""), "light", "balance");
    write_file("file.toml", ledger_base + "reference = { file = \"ref.exr\" }\n" + both);
    write_file("rendered.toml", replaced(ledger_base, "cornell-box", "furnace") + "reference = { samples = 16 }\n" + both);
    render_reference("path");
  }

  void render_reference(const std::string& method) {
    const Outcome made = run({"render", "builtin:cornell-box", "-i", method, "--spp", "4", "--resolution", "8x8", "--seed", "7",
                              "--threads", "1", "-o", "ref.exr"});
    ASSERT_EQ(made.status, 0) << made.err;
  }

  std::string run_to(const std::string& out, const std::string& experiment, const std::string& filter = "builtin") {
    const Outcome ran = run({"run", experiment, "--threads", "1", "--out", out, "--filter", filter});
    EXPECT_EQ(ran.status, 0) << ran.err;
    return ran.err;
  }

  RunLog log(const std::string& out) const { return read_log((directory_ / out / "runs.jsonl").string()); }
  double error_of(const std::string& out, const std::string& component) const {
    const RunLog read = log(out);
    for (const LedgerRecord* record : done_records_of<LedgerRecord>(read))
      if (record->cell.integrator == component) return record->trials.front().error;
    return -1;
  }

  static constexpr const char* another = "is not the one that its cells were measured against: they run again";
};

TEST_F(LedgerReference, ThatIsAnotherFileTakesWhatItMeasuredOutOfTheLog) {
  EXPECT_EQ(run_to("out", "file.toml", " c ").find(another), std::string::npos);
  const double before = error_of("out", "c");
  render_reference("bdpt");
  EXPECT_NE(run_to("out", "file.toml").find(another), std::string::npos);
  EXPECT_NE(error_of("out", "c"), before);
  EXPECT_EQ(error_of("out", "c"), error_of("out", "d"));
  EXPECT_NE(run_to("out", "file.toml").find("2 of 2 cells are done already"), std::string::npos);
  render_reference("path");
  EXPECT_NE(run_to("out", "file.toml").find(another), std::string::npos) << "though no cell is pending";
  EXPECT_EQ(error_of("out", "c"), before);
  EXPECT_EQ(error_of("out", "d"), before);
}

TEST_F(LedgerReference, ThatIsRenderedStaysWhileARunGoesOn) {
  run_to("out", "rendered.toml", " c ");
  ASSERT_EQ(log("out").references.size(), 1u);
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "cache/etendue/references")) {
    if (entry.path().extension() != ".exr") continue;
    std::map<std::string, std::string> attributes;
    Image image = read_exr(entry.path().string(), &attributes);
    for (dvec3& pixel : image.pixels) pixel *= 2;
    write_exr(entry.path().string(), image, attributes);
  }
  EXPECT_NE(run_to("out", "rendered.toml").find("1 of 2 cells are done already"), std::string::npos);
  EXPECT_EQ(error_of("out", "c"), error_of("out", "d"));
}

TEST_F(LedgerReference, ThatIsDamagedIsToldAndMadeAgain) {
  run_to("out", "file.toml");
  const double before = error_of("out", "c");
  write_file("out/" + log("out").references.at(0).file, "no image");
  EXPECT_NE(run({"report", "out"}).err.find("2 cells are not believed"), std::string::npos);
  EXPECT_NE(run_to("out", "file.toml").find("it is made again"), std::string::npos);
  EXPECT_EQ(run({"report", "out"}).err.find("not believed"), std::string::npos);
  EXPECT_EQ(error_of("out", "c"), before);
}

TEST_F(LedgerReference, ThoseOfMergedLogsAreHeldAgainstEachOther) {
  run_to("one", "file.toml", " c ");
  render_reference("bdpt");
  run_to("two", "file.toml", " d ");
  ASSERT_EQ(run({"report", "one", "two", "--out", "both"}).status, 0);
  EXPECT_NE(read_text_file(directory_ / "both/report.html").find("against different references"), std::string::npos);
}

// Older logs have no line of the reference.
TEST_F(LedgerReference, ThatIsNotLoggedLeavesWhatIsDone) {
  run_to("out", "file.toml");
  const std::string text = read_text_file(directory_ / "out/runs.jsonl");
  const std::size_t end = text.find('\n', text.find("\"type\":\"reference\"")), begin = text.rfind('\n', end - 1);
  write_file("out/runs.jsonl", replaced(text, text.substr(begin, end - begin), ""));
  EXPECT_EQ(done_records_of<LedgerRecord>(log("out")).size(), 2u);
  EXPECT_NE(run_to("out", "file.toml").find("2 of 2 cells are done already"), std::string::npos);
}

TEST(SecondLevel, IsPutInAndTakenOut) {
  const Scene scene = load_scene("builtin:mesh?triangles=1k", {"test"});
  const Scene two = with_second_level(scene);
  EXPECT_TRUE(two.has_instances());
  const std::optional<Scene> one = without_second_level(two);
  ASSERT_TRUE(one.has_value());
  EXPECT_FALSE(one->has_instances());
  EXPECT_EQ(one->triangle_count(), two.triangle_count());
  EXPECT_EQ(one->objects[0].shape_of.size(), one->objects[0].geometry.primitive_count());
  EXPECT_FALSE(without_second_level(with_second_level(load_scene("builtin:lambert-sphere", {"test"}))).has_value())
      << "a sphere is no triangle";
}

// A mirrored, stretched instance keeps the outside of its surface.
TEST(SecondLevel, InstancesWrittenOutLookAlike) {
  Scene scene = load_scene("builtin:mesh?triangles=1k", {"test"});
  Object object = scene.objects[0];
  for (Shape& shape : object.shapes) shape.first_light = no_id;
  scene.objects.push_back(object);
  const Transform mirrored = Transform::translate({0, 0.1f, 0}) * Transform::scale({-0.5f, 0.4f, 0.5f});
  scene.instances.push_back({1, mirrored});
  const Scene flat = without_second_level(scene).value();
  const SceneNeeds needs = scene_needs(scene), flat_needs = scene_needs(flat);
  Budget budget;
  budget.samples = 1;
  budget.checkpoints.linear = 1;
  const Method path{"path", {}};
  const Image a = run_cell({scene, needs, default_accel(), path, 1, ivec2(16), budget}).image;
  const Image b = run_cell({flat, flat_needs, default_accel(), path, 1, ivec2(16), budget}).image;
  int different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) different += glm::length(a.pixels[i] - b.pixels[i]) > 1e-3;
  EXPECT_LE(different, 8) << "rounding may send a few paths elsewhere";
}

}  // namespace
}  // namespace etendue
