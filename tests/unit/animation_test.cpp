// Experiments on change over time, from their TOML to their report.
#include "experiments/kinds/animation/animation.h"
#include "experiments/run/run.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/kind_records.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace etendue {
namespace {

constexpr const char* animation_experiment =
    "title = \"Moving\"\n"
    "scenes = [\"builtin:cornell-spheres\"]\n"
    "accels = [\"binned-sah\", { name = \"median\", leaf_size = 2 }]\n"
    "seeds = 2\n"
    "[dynamic]\n"
    "frames = 4\n"
    "resolution = 16\n"
    "repetitions = 1\n"
    "motions = [\"twist\", { name = \"scatter\", objects = 8, moving = 0.5 }]\n"
    "policies = [\"refit\", \"rebuild\", { name = \"hybrid\", sah_growth = 1.1, least_gain = 0 }]\n";

std::string animation_with(const std::string& from, const std::string& to) { return replaced(animation_experiment, from, to); }

TEST(AnimationConfig, ValidFileIsReadInFull) {
  const ExperimentConfig config = parse_experiment(animation_experiment, "x.toml");
  EXPECT_EQ(choice_of<AnimationChoice>(config).frames, 4);
  EXPECT_EQ(choice_of<AnimationChoice>(config).resolution, 16);
  ASSERT_EQ(choice_of<AnimationChoice>(config).policies.size(), 3u);
  EXPECT_EQ(choice_of<AnimationChoice>(config).policies[2].label(), "hybrid least_gain=0 sah_growth=1.1");
  EXPECT_EQ(choice_of<AnimationChoice>(config).motions[1].label(), "scatter moving=0.5 objects=8");
  EXPECT_EQ(make_cells(config).size(), 8u);
  EXPECT_EQ(make_cells(config)[0].name.key(), "builtin:cornell-spheres | binned-sah | twist | seed=1");
}

TEST(AnimationConfig, QuickHasADefault) {
  const ExperimentConfig config = parse_experiment(animation_experiment, "x.toml", {true, {}});
  EXPECT_EQ(config.seeds.size(), 1u);
  EXPECT_EQ(choice_of<AnimationChoice>(config).frames, 10);
  EXPECT_EQ(choice_of<AnimationChoice>(config).motions.size(), 2u) << "what is asked stays";
}

TEST(AnimationConfig, MotionsAndPoliciesHaveDefaults) {
  const ExperimentConfig config = parse_experiment("scenes = [\"builtin:mesh\"]\n[dynamic]\nframes = 3\n", "x.toml");
  EXPECT_EQ(choice_of<AnimationChoice>(config).motions.size(), 4u);
  EXPECT_EQ(choice_of<AnimationChoice>(config).policies.size(), 3u);
}

TEST(AnimationConfig, SlipsAreErrorsAtTheirPlace) {
  const std::tuple<std::string, std::string, std::string> slips[] = {
      {animation_with("frames = 4", "frame = 4"), "x.toml:6:1", "frames"},
      {animation_with("frames = 4", "frames = 0"), "x.toml:6:10", "out of range"},
      {animation_with("\"twist\"", "\"twizt\""), "x.toml:9:12", "twist"},
      {animation_with("objects = 8", "object = 8"), "x.toml:9:41", "objects"},
      {animation_with("moving = 0.5", "moving = 5"), "x.toml:9:", "moving"},
      {animation_with("\"refit\"", "\"refitt\""), "x.toml:10:13", "refit"},
      {animation_with("sah_growth = 1.1", "sah_growth = 0.5"), "x.toml:10:", "sah_growth"},
      {animation_with("\"refit\"", "{ name = \"refit\", sah_growth = 2 }"), "x.toml:10:", "sah_growth"},
      {animation_with("\"binned-sah\"", "\"octree\""), "x.toml:3:11", "cannot change over time"},
      {animation_with("leaf_size = 2", "layout = \"bvh8\""), "x.toml:3:", "binary"},
      {animation_with("seeds = 2", "budget = { samples = 3 }"), "x.toml:4:1", "dynamic"},
      {animation_with("seeds = 2", "integrators = [\"path\"]"), "x.toml:4:1", "dynamic"},
      {"scenes = [\"builtin:mesh\"]\ndynamic = 3\n", "x.toml:2:11", "a table"}};
  for (const auto& [text, place, piece] : slips) {
    const std::string what = config_error(text);
    EXPECT_TRUE(what.starts_with(place)) << what;
    EXPECT_NE(what.find(piece), std::string::npos) << what;
  }
}

TEST(AnimationRecord, LineIsReadBack) {
  AnimationRecord record;
  record.cell = {"builtin:mesh", "sah", "twist \"2\"", 7};
  record.manifest = "m";
  record.status = "done";
  record.primitives = 12;
  record.rays = {5, 6};
  record.changed = {0, 0.1};
  record.rebuilt_sah_cost = {10, 0.333333333};
  record.policies = {{"refit", {0.1, 0.2}, {0.3, 0.4}, {10, 11}, {1, 0}, 2}};
  const std::string line = record.line();
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto read = read_back<AnimationRecord>(line);
  EXPECT_EQ(read.cell, record.cell);
  EXPECT_EQ(read.rebuilt_sah_cost, record.rebuilt_sah_cost);
  ASSERT_EQ(read.policies.size(), 1u);
  EXPECT_EQ(read.policies[0].trace_s, record.policies[0].trace_s);
  EXPECT_EQ(read.policies[0].disagreements, 2u);
  EXPECT_EQ(read.line(), line);
}

class AnimationRun : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file("moving.toml", animation_experiment);
  }
  RunLog log(const std::string& out) { return read_log((directory_ / out / "runs.jsonl").string()); }
};

// The figures that no clock touches.
std::vector<std::vector<double>> outcome_of(const RunLog& log) {
  std::vector<std::vector<double>> outcome;
  for (const AnimationRecord* logged : records_of<AnimationRecord>(log)) {
    const AnimationRecord& record = *logged;
    outcome.push_back(record.changed);
    outcome.push_back(record.rays);
    outcome.push_back(record.rebuilt_sah_cost);
    for (const PolicyRecord& policy : record.policies) {
      outcome.push_back(policy.sah_cost);
      outcome.push_back(policy.rebuilt);
    }
  }
  return outcome;
}

TEST_F(AnimationRun, WritesLogChartsAndPageAndResumes) {
  const Outcome first = run({"run", "moving.toml", "--threads", "1", "--filter", "twist"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.out.find("hybrid"), std::string::npos) << "the table is on stdout";
  const Outcome rest = run({"run", "moving.toml", "--threads", "1"});
  ASSERT_EQ(rest.status, 0) << rest.err;
  EXPECT_NE(rest.err.find("4 of 8 cells are done already"), std::string::npos) << rest.err;
  const RunLog written = log("out/moving");
  ASSERT_EQ(written.records.size(), 8u);
  for (const AnimationRecord* logged : records_of<AnimationRecord>(written)) {
    const AnimationRecord& record = *logged;
    EXPECT_EQ(record.status, "done") << record.error;
    ASSERT_EQ(record.policies.size(), 3u);
    for (const PolicyRecord& policy : record.policies) {
      EXPECT_EQ(policy.disagreements, 0u);
      ASSERT_EQ(policy.trace_s.size(), 5u);
      if (policy.policy == "rebuild") {
        for (int f = 0; f < 5; ++f) EXPECT_NEAR(policy.sah_cost[f] / record.rebuilt_sah_cost[f], 1, 0.05);
      }
    }
  }
  const auto charts = directory_ / "out/moving/charts";
  for (const char* name : {"frame-time", "update-time", "tree-quality", "trace-speed"})
    EXPECT_TRUE(std::filesystem::exists(charts / (std::string(name) + "-cornell-spheres-twist-binned-sah.svg"))) << name;
  const std::string page = read_text_file(directory_ / "out/moving/report.html");
  EXPECT_NE(page.find("Change over time"), std::string::npos);
  EXPECT_NE(page.find("takes the least time"), std::string::npos);
  EXPECT_EQ(page.find("holds no finished cell"), std::string::npos);

  // Torn in the middle of a line, it goes on with that cell.
  std::string text = read_text_file(directory_ / "out/moving/runs.jsonl");
  text.resize(text.rfind('\n', text.size() - 2) - 40);  // without the line that says that all of it is done
  std::ofstream(directory_ / "out/moving/runs.jsonl") << text;
  const Outcome again = run({"run", "moving.toml", "--threads", "1"});
  EXPECT_NE(again.err.find("7 of 8 cells are done already"), std::string::npos) << again.err;
  EXPECT_EQ(outcome_of(log("out/moving")), outcome_of(written));
}

TEST_F(AnimationRun, TreesDoNotDependOnTheThreads) {
  ASSERT_EQ(run({"run", "moving.toml", "--threads", "1", "--out", "one"}).status, 0);
  ASSERT_EQ(run({"run", "moving.toml", "--threads", "3", "--out", "three"}).status, 0);
  EXPECT_EQ(outcome_of(log("one")), outcome_of(log("three")));
}

TEST_F(AnimationRun, ShardsMergeInTheReport) {
  for (const char* shard : {"0/2", "1/2"})
    ASSERT_EQ(run({"run", "moving.toml", "--shard", shard, "--threads", "1", "--out", std::string("s") + shard[0]}).status, 0);
  EXPECT_EQ(log("s0").records.size() + log("s1").records.size(), 8u);
  EXPECT_EQ(merge_logs({log("s0"), log("s1")}).records.size(), 8u);
  EXPECT_EQ(run({"report", "s0", "s1", "--out", "merged"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(directory_ / "merged/tables/animations.csv"));
}

TEST_F(AnimationRun, DryRunListsCells) {
  const Outcome outcome = run({"run", "moving.toml", "--dry-run"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 8);
  EXPECT_NE(outcome.err.find("4 frames"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out"));
}

TEST_F(AnimationRun, SceneWithInstancesFailsItsCells) {
  write_file("two.pbrt",
             "LookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n"
             "ObjectBegin \"ball\"\nShape \"sphere\" \"float radius\" [0.5]\nObjectEnd\n"
             "ObjectInstance \"ball\"\nTranslate 1 0 0\nObjectInstance \"ball\"\n");
  write_file("two.toml", "scenes = [\"two.pbrt\"]\n[dynamic]\nframes = 2\nmotions = \"twist\"\n");
  const Outcome outcome = run({"run", "two.toml", "--threads", "1"});
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  ASSERT_EQ(log("out/two").records.size(), 1u);
  EXPECT_NE(log("out/two").records[0]->error.find("instances"), std::string::npos);
}

}  // namespace
}  // namespace etendue
