// runs.jsonl: what is written is read back, and a torn end is cut off.
#include "experiments/log/json_line.h"
#include "experiments/log/log.h"
#include "experiments/run/run_directory.h"
#include "framework/core/error.h"
#include "tests/unit/silent_observer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace etendue {
namespace {

CheckpointRecord checkpoint(std::uint64_t seed, std::uint64_t iterations) {
  CheckpointRecord r;
  r.cell = {"builtin:x \"quoted\"", "sah", "path", seed};
  r.manifest = "m";
  r.iterations = iterations;
  r.time_s = 0.1 * static_cast<double>(iterations);
  r.cpu_s = 1.0 / 3;
  r.phases_s = {{"build", 1e-300}, {"other", 0.25}};
  r.metrics = {{"relmse", 0.1}, {"bias", -1e-17}};
  r.counters = {{"rays", 18446744073709551615ull}};
  r.peak_memory_bytes = 123;
  r.non_finite = 2;
  return r;
}

CellRecord cell(std::uint64_t seed, const std::string& status = "done") {
  return {{"builtin:x \"quoted\"", "sah", "path", seed},
          status,
          status == "done" ? "" : "boom",
          "images/a.exr",
          "ff",
          "unbiased",
          -1,
          0.02,
          "é"};
}

TEST(LogLines, ParametersHaveTheirTypes) {
  CellRecord record = cell(1);
  EXPECT_EQ(to_json_line(record).find("parameters"), std::string::npos) << "as in older logs";
  record.parameters = {{"final_gather", true}, {"photons", std::int64_t{200000}}, {"alpha", 1.0}, {"policy", "knn \"a b\""}};
  record.accel_parameters = {{"leaf_size", std::int64_t{-1}}};
  const Json json = Json::parse(to_json_line(record));
  EXPECT_EQ(json.at("parameters").dump(), R"({"alpha":1.0,"final_gather":true,"photons":200000,"policy":"knn \"a b\""})");
  const auto read = read_record<CellRecord>(json);
  EXPECT_EQ(read.parameters, record.parameters);
  EXPECT_EQ(read.accel_parameters, record.accel_parameters);
  for (const char* bad : {"null", "[1]", "18446744073709551615"}) {
    Json wrong = json;
    wrong["parameters"]["alpha"] = Json::parse(bad);
    EXPECT_THROW(read_record<CellRecord>(wrong), Json::exception) << bad;
  }
}

class Log : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::temp_directory_path() / ("etendue-log-" + std::to_string(getpid()) + "-" +
                                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
    path_ = (directory_ / "runs.jsonl").string();
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  void write_cell(std::uint64_t seed, const std::string& status = "done") {
    LogWriter(path_).append(
        {to_json_line(checkpoint(seed, 1)), to_json_line(checkpoint(seed, 2)), to_json_line(cell(seed, status))});
  }
  void append_raw(const std::string& text) { std::ofstream(path_, std::ios::app | std::ios::binary) << text; }
  std::string content() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  std::filesystem::path directory_;
  std::string path_;
};

TEST_F(Log, RecordsAreReadBackExactly) {
  const ManifestRecord manifest{
      "id", "0.1", "abc", "GCC", "-O2", "cpu", "title", "hash", 7, "a.toml", "--quick", "title = \"t\"\n", 2.5};
  ReferenceRecord reference{"s", "h", "closed form", "references/s.exr", "agree", 1e-7, 64, 32};
  reference.warnings = {"a warning"};
  StructureRecord structure;
  structure.scene = "s";
  structure.structure = "sah";
  structure.layout = "binary";
  structure.triangles = 5;
  structure.note = "left out";
  structure.build_s = {0.125, 0.1, 0.5};
  structure.parallel_build_s = {0.0625, 0.05, 0.25};
  structure.speed(RayKind::shadow) = {3.5, 3.25, 3.75};
  structure.batched_mrays_per_s[index_of(RayKind::gather)] = {4, 3, 5};
  structure.to_embree[index_of(RayKind::photon)] = {1.25, 1.125, 1.5};
  structure.to_robust_embree[index_of(RayKind::primary)] = {1.5, 1.5, 1.5};
  structure.batched_to_embree[index_of(RayKind::shadow)] = {1.25, 1.0, 1.5};
  structure.epo_cost = 0.75;
  structure.checked = 100;
  structure.threads = 3;
  structure.disagreements = 1;
  LogWriter(path_).append({to_json_line(manifest), to_json_line(reference), to_json_line(structure)});
  write_cell(1);
  const RunLog log = read_log(path_);
  ASSERT_EQ(log.manifests.size(), 1u);
  EXPECT_EQ(to_json_line(log.manifests[0]), to_json_line(manifest));
  ASSERT_EQ(log.references.size(), 1u);
  EXPECT_EQ(to_json_line(log.references[0]), to_json_line(reference));
  ASSERT_EQ(log.structures.size(), 1u);
  EXPECT_EQ(to_json_line(log.structures[0]), to_json_line(structure));
  ASSERT_EQ(log.checkpoints.size(), 2u);
  EXPECT_EQ(to_json_line(log.checkpoints[1]), to_json_line(checkpoint(1, 2)));
  EXPECT_EQ(log.checkpoints[0].counters.at("rays"), 18446744073709551615ull);
  EXPECT_EQ(log.checkpoints[0].metrics.at("relmse"), 0.1);
  ASSERT_EQ(log.cells.size(), 1u);
  EXPECT_EQ(to_json_line(log.cells[0]), to_json_line(cell(1)));
  EXPECT_TRUE(content().starts_with("{\"type\":\"manifest\""));
}

TEST_F(Log, TheLastTextOfAnExperimentCounts) {
  ManifestRecord manifest{"id", "0.1", "abc", "GCC", "-O2", "cpu", "title", "hash", 7, "a.toml", "", "exponent = -1\n"};
  const std::string path = (directory_ / "run").string();
  SilentObserver observer;
  const auto open = [&] { RunDirectory(path, manifest, {}, false, observer); };
  open();
  manifest.experiment = "exponent = -2\n";
  manifest.options = "--quick";
  open();
  path_ = path + "/runs.jsonl";
  const std::string once = content();
  open();
  EXPECT_EQ(content(), once) << "nothing new to say";
  const RunLog log = read_log(path_);
  ASSERT_EQ(log.manifests.size(), 1u);
  EXPECT_EQ(to_json_line(log.manifests[0]), to_json_line(manifest));
}

TEST_F(Log, SaysHowLongItTookUnlessARunWasStopped) {
  const ManifestRecord manifest{"id", "0.1", "abc", "GCC", "-O2", "cpu", "title", "hash", 7, "a.toml", "", ""};
  SilentObserver observer;
  const auto took_s = [&](bool is_stopped) {
    const std::string path = (directory_ / (is_stopped ? "stopped" : "whole")).string();
    if (is_stopped) RunDirectory(path, manifest, {}, false, observer);
    RunDirectory(path, manifest, {}, false, observer).finish();
    const RunLog log = read_log(path + "/runs.jsonl");
    EXPECT_TRUE(log.finished);
    return log.took_s;
  };
  EXPECT_GT(took_s(false), 0);
  EXPECT_EQ(took_s(true), 0);
}

TEST_F(Log, TornEndIsDroppedAndCutOffAtAnyByte) {
  write_cell(1);
  const std::string whole = content();
  write_cell(2);
  const std::string both = content();
  for (std::size_t length = whole.size(); length < both.size(); length += 37) {
    std::ofstream(path_, std::ios::binary) << both.substr(0, length);
    EXPECT_EQ(read_log(path_).cells.size(), 1u);
    EXPECT_EQ(read_log(path_).checkpoints.size(), 2u);
    const LogWriter repaired(path_);
    EXPECT_EQ(content(), whole);
  }
}

TEST_F(Log, WritingGoesOnAfterARepair) {
  write_cell(1);
  append_raw(to_json_line(checkpoint(2, 1)) + "\n{\"type\":\"chec");
  write_cell(3);
  const RunLog log = read_log(path_);
  ASSERT_EQ(log.cells.size(), 2u);
  EXPECT_EQ(log.cells[1].cell.seed, 3u);
  EXPECT_EQ(log.checkpoints.size(), 4u);
}

TEST_F(Log, BlockCutShortByAFullDiskIsTakenBack) {
  write_cell(1);
  const std::string whole = content();
  LogWriter writer(path_);
  const std::vector<std::string> block{to_json_line(checkpoint(2, 1)), to_json_line(cell(2))};
  const auto at_signal = std::signal(SIGXFSZ, SIG_IGN);  // too large a file is an error of the write then
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit full{whole.size() + 100, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  EXPECT_THROW(writer.append(block), Error);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, at_signal);
  EXPECT_EQ(content(), whole);
  writer.append(block);
  EXPECT_EQ(read_log(path_).cells.size(), 2u);
}

TEST_F(Log, EveryFlippedBitIsNoticed) {
  write_cell(1);
  write_cell(2);
  LogWriter(path_).append({finished_line()});
  const std::string whole = content();
  ASSERT_TRUE(read_log(path_).finished);
  for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 13) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(path_, std::ios::binary) << flipped;
    std::vector<DamagedLine> damaged;
    const RunLog log = read_log(path_, damaged);
    EXPECT_TRUE(!damaged.empty() || log.torn) << "bit " << bit;
    EXPECT_FALSE(log.finished && damaged.empty()) << "bit " << bit;
    if (!damaged.empty()) {
      EXPECT_THROW(read_log(path_), Error);
    }
  }
}

TEST_F(Log, DamagedLinesAreNamedAndSetAside) {
  write_cell(1);
  write_cell(2);
  std::string text = content();
  text[text.find("\"relmse\"") + 3] ^= 4;  // in the first line
  std::ofstream(path_, std::ios::binary) << text;
  std::vector<DamagedLine> damaged;
  const RunLog log = read_log(path_, damaged);
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_TRUE(damaged[0].what.starts_with(path_ + ":1: ")) << damaged[0].what;
  EXPECT_NE(damaged[0].what.find("checksum"), std::string::npos) << damaged[0].what;
  set_aside(path_, damaged);
  EXPECT_EQ(content(), text.substr(text.find('\n') + 1));
  std::ifstream beside(path_ + ".damaged", std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(beside), {}), text.substr(0, text.find('\n') + 1));
}

TEST_F(Log, CellWithoutAllItsCheckpointsIsDamaged) {
  CellRecord whole = cell(1);
  whole.checkpoints = 2;
  LogWriter(path_).append({to_json_line(checkpoint(1, 1)), to_json_line(whole)});
  EXPECT_THROW(read_log(path_), Error);
}

TEST_F(Log, AnotherHashTakesBackWhatWasLoggedOfAScene) {
  const std::string name = cell(1).cell.scene;
  const auto append = [&](const std::vector<std::string>& lines) { LogWriter(path_).append(lines); };
  const ReferenceRecord reference{name, "h", "closed form", "references/s.exr", "agree", 1e-7, 64, 32, {3, "aa"}};
  append({to_json_line(SceneRecord{name, "1"}), to_json_line(SceneRecord{"other", "1"}), to_json_line(reference)});
  write_cell(1);
  append({to_json_line(SceneRecord{name, "1"}), to_json_line(reference), to_json_line(SceneRecord{"other", "2"})});
  EXPECT_EQ(read_log(path_).cells.size(), 1u);
  ReferenceRecord another = reference;
  another.stamp.hash = "bb";
  append({to_json_line(another)});
  EXPECT_TRUE(read_log(path_).cells.empty());
  write_cell(1);
  EXPECT_EQ(read_log(path_).checkpoints.size(), 2u);
  append({to_json_line(SceneRecord{name, "2"})});
  EXPECT_TRUE(read_log(path_).cells.empty());
  EXPECT_TRUE(read_log(path_).references.empty());
  EXPECT_TRUE(read_log(path_).checkpoints.empty());
}

TEST_F(Log, MalformedLineInsideIsAnErrorWithItsNumber) {
  write_cell(1);
  append_raw("nonsense\n");
  write_cell(2);
  try {
    read_log(path_);
    FAIL();
  } catch (const Error& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with(path_ + ":4: ")) << e.what();
  }
}

TEST_F(Log, CellLoggedTwiceCountsOnceByItsLast) {
  write_cell(1, "failed");
  write_cell(2);
  write_cell(1);
  const RunLog log = read_log(path_);
  ASSERT_EQ(log.cells.size(), 2u);
  EXPECT_EQ(log.cells[0].status, "done");
  EXPECT_EQ(log.checkpoints.size(), 4u);
}

TEST_F(Log, MergingShardsKeepsEachCellOnce) {
  write_cell(1);
  const RunLog first = read_log(path_);
  write_cell(2);
  const RunLog merged = merge_logs({first, read_log(path_)});
  EXPECT_EQ(merged.cells.size(), 2u);
  EXPECT_EQ(merged.checkpoints.size(), 4u);
}

TEST_F(Log, MissingFileIsAnError) { EXPECT_THROW(read_log(path_), Error); }

}  // namespace
}  // namespace etendue
