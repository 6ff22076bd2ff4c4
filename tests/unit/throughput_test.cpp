// Experiments on throughput: what they log, and what a log of several commits shows.
#include "experiments/kind.h"
#include "experiments/kinds/throughput/throughput_record.h"
#include "framework/core/isa.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/silent_observer.h"

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <fstream>

namespace etendue {
namespace {

const std::string throughput_base =
    "scenes = [\"builtin:cornell-box\"]\n"
    "integrators = [\"path\", { name = \"photon-map\", photons = \"2k\" }, \"irradiance-cache\"]\n"
    "resolution = [16, 16]\n"
    "throughput = { repetitions = 2, time = \"0.01s\" }\n";

TEST(Throughput, KeysThatWouldChangeNothingAreErrors) {
  expect_error(throughput_base + "accels = [\"sah\"]\n", "x.toml:5:1", "of no use beside [throughput]");
  expect_error(replaced(throughput_base, "repetitions = 2", "isa = [\"avx3\"]"), "x.toml:4:23", "avx2");
  expect_error(replaced(throughput_base, "repetitions = 2", "repetition = 2"), "x.toml:4:16", "repetitions");
  expect_error("scenes = [\"builtin:cornell-box\"]\nthroughput = {}\n", "x.toml:2:14", "[[integrators]]");
  expect_error(throughput_base + "seeds = 2\n", "x.toml:5:9", "expected one beside [throughput]");
}

TEST(Throughput, EveryInstructionSetIsMeasuredAndResumed) {
  const auto directory = std::filesystem::temp_directory_path() / ("etendue-throughput-" + std::to_string(getpid()));
  std::filesystem::create_directories(directory);
  std::ofstream(directory / "t.toml") << throughput_base;
  RunOptions options;
  options.experiment = (directory / "t.toml").string();
  options.out = (directory / "out").string();
  SilentObserver observer;
  const Isa before = chosen_isa();
  EXPECT_EQ(execute_run(plan_run(options), observer).done, 3u);
  EXPECT_EQ(chosen_isa(), before);
  EXPECT_EQ(execute_run(plan_run(options), observer).skipped, 3u);
  const RunLog log = read_log((directory / "out/runs.jsonl").string());
  const auto records = records_of<ThroughputRecord>(log);
  ASSERT_EQ(records.size(), 3u);
  for (const ThroughputRecord* record : records) {
    EXPECT_EQ(record->error, "");
    EXPECT_EQ(record->sets.size(),
              std::ranges::count_if(isa_options, [](auto name) { return is_supported(isa_of_option(name)); }));
    EXPECT_EQ(record->image_hash.size(), 16u);
    const bool is_photon_map = record->cell.integrator == "photon-map photons=2000";
    const Parameters set{{"photons", std::int64_t{2000}}};
    EXPECT_EQ(record->parameters, is_photon_map ? set : Parameters{});
    for (const Throughput& set : record->sets) {
      EXPECT_GT(set.samples_per_s.median, 0);
      EXPECT_GT(set.rays_per_s.median, set.samples_per_s.median);
      EXPECT_EQ(set.photons_per_s.median > 0, is_photon_map);
      EXPECT_EQ(set.records_per_s.median > 0, record->cell.integrator.starts_with("irradiance-cache"));
      double all = 0;
      for (const auto& [phase, share] : set.shares) all += share;
      EXPECT_NEAR(all, 1, 0.1);
    }
  }
  std::filesystem::remove_all(directory);
}

TEST(Throughput, CommitsOfOneLogAreComparedWithTheFirst) {
  RunLog log;
  for (const auto& [commit, speed] : {std::pair("aaa", 100.0), std::pair("bbb", 250.0)}) {
    auto record = std::make_shared<ThroughputRecord>();
    record->cell = {"box", commit, "path", 1};
    record->status = "done";
    record->sets = {{"avx2", 4, {speed, speed - 1, speed + 1}, {1000, 990, 1010}, {}, {}, {{"trace", 1.0}}}};
    log.records.push_back(record);
  }
  const KindReport report = throughput_report(log);
  const Table& table = report.tables.at(0);
  ASSERT_EQ(table.rows.size(), 1u) << "the newest commit alone";
  EXPECT_EQ(table.rows[0][*column_of(table, "over_first")].text, "2.50");
  ASSERT_EQ(report.figures.at(0).figures.size(), 2u);
  const auto& points = report.figures[0].figures[1].panels.at(0).series.at(0).points;
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].y, 250);
  EXPECT_EQ(report.answer, "path traces the most camera samples: 250 a second on box with AVX2") << "and no 0.0 M";
}

}  // namespace
}  // namespace etendue
