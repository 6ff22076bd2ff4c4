// The curves of a log as a program reads them, and the examples of docs/log.md where their languages are installed.
#include "experiments/report/report.h"
#include "experiments/report/tables.h"
#include "tests/places.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/report_helpers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

namespace etendue {
namespace {

using namespace report_test;

// No field of these tests holds a comma.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::vector<std::string> header;
  std::vector<std::map<std::string, std::string>> rows;
  for (std::string line, cell; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream parts(line + ",");
    while (std::getline(parts, cell, ',')) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      continue;
    }
    EXPECT_EQ(cells.size(), header.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(header.size(), cells.size()); ++i) row[header[i]] = cells[i];
  }
  return rows;
}

TEST(CurvesCsv, HasARowForEachMetricOfEachCheckpoint) {
  RunLog log = small_log();
  log.checkpoints.front().regions["left"] = {{"mse", 0.25}};
  const auto rows = rows_of(curves_csv(arrange(log)));
  ASSERT_EQ(rows.size(), 2u * 3 * 8 * 3 + 1);
  EXPECT_EQ(rows[0].at("experiment"), "A question");
  EXPECT_EQ(rows[0].at("scene"), "builtin:room");
  EXPECT_EQ(rows[0].at("integrator"), "path");
  EXPECT_EQ(rows[0].at("metric"), "bias");
  EXPECT_DOUBLE_EQ(std::stod(rows[0].at("value")), log.checkpoints.front().metrics.at("bias"));
  EXPECT_DOUBLE_EQ(std::stod(rows[0].at("time_s")), 0.1);
  EXPECT_EQ(rows[0].at("region"), "");
  EXPECT_EQ(rows[3].at("region"), "left");
  EXPECT_EQ(rows[3].at("value"), "0.25");
}

// A name is cut at blanks, and what is logged beside it is not.
TEST(CurvesCsv, HasAColumnForEachParameter) {
  RunLog log;
  log.manifests.push_back(manifest());
  log.manifests.back().file = "experiments/first.toml";
  add_cells(log, "room", {"ppm policy=a b photons=1000 alpha=0.5 gather=true", "sah leaf_size=4"}, 1);
  add_cells(log, "room", {"ppm photons=2000", "sah leaf_size=4"}, 1);
  for (CellRecord& cell : log.cells) cell.accel_parameters = {{"leaf_size", std::int64_t{4}}};
  log.cells.front().parameters = {{"policy", "a b"}, {"photons", std::int64_t{1000}}, {"alpha", 0.5}, {"gather", true}};
  log.cells.back().parameters = {{"photons", std::int64_t{2000}}};
  const auto rows = rows_of(curves_csv(arrange(log)));
  const auto &first = rows.front(), &last = rows.back();
  EXPECT_EQ(first.at("experiment"), "first");
  EXPECT_EQ(first.at("accel.name"), "sah");
  EXPECT_EQ(first.at("accel.leaf_size"), "4");
  EXPECT_EQ(first.at("integrator.name"), "ppm");
  EXPECT_EQ(first.at("integrator.policy"), "a b");
  EXPECT_EQ(first.at("integrator.photons"), "1000");
  EXPECT_EQ(first.at("integrator.alpha"), "0.5");
  EXPECT_EQ(first.at("integrator.gather"), "true");
  EXPECT_FALSE(first.contains("integrator.b"));
  EXPECT_EQ(last.at("integrator.photons"), "2000");
  EXPECT_EQ(last.at("integrator.alpha"), "");
}

TEST(CurvesCsv, LeavesOutCellsThatFailed) {
  RunLog log = small_log();
  log.cells.front().status = "failed";
  EXPECT_EQ(rows_of(curves_csv(arrange(log))).size(), 2u * 3 * 8 * 3 - 8 * 3);
}

// --- the examples ---

class LogExamples : public ::testing::Test {
 protected:
  LogExamples() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    const RunLog log = small_log();
    LogWriter writer((folder_ / "runs.jsonl").string());
    std::vector<std::string> lines{to_json_line(log.manifests.front()), to_json_line(log.references.front())};
    for (const CellRecord& cell : log.cells) {
      for (const CheckpointRecord& checkpoint : log.checkpoints)
        if (checkpoint.cell == cell.cell) lines.push_back(to_json_line(checkpoint));
      lines.push_back(to_json_line(cell));
    }
    writer.append(lines);
    write_report({folder_.string()}, folder_.string(), {.check_files = false});
  }
  ~LogExamples() override { std::filesystem::remove_all(folder_); }

  // Runs each block of the language in the folder; returns what they print.
  std::string run_blocks(const std::string& language, const std::string& command) {
    const std::string text = read_text_file(std::string(project_folder) + "docs/log.md"), fence = "```" + language + "\n";
    std::string printed;
    for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at + 1)) {
      const std::size_t begin = at + fence.size();
      std::ofstream(folder_ / "example") << text.substr(begin, text.find("```", begin) - begin);
      const int status = std::system(fmt::format("cd '{}' && {} example > out 2>&1", folder_.string(), command).c_str());
      EXPECT_EQ(status, 0) << file_text(folder_ / "out");
      printed += file_text(folder_ / "out");
    }
    return printed;
  }

  static bool has(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()) == 0; }

  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / fmt::format("etendue_log_examples_{}", ::getpid());
};

TEST_F(LogExamples, RunInPandas) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {  // Debian's packages are those of its own Python
    if (!has(std::string(python) + " -c 'import pandas'")) continue;
    const std::string printed = run_blocks("python", python);
    EXPECT_NE(printed.find("sppm"), std::string::npos) << printed;
    EXPECT_NE(printed.find("128"), std::string::npos) << printed;  // the last iterations
    return;
  }
  GTEST_SKIP() << "pandas is not installed";
}

TEST_F(LogExamples, RunInR) {
  if (!has("Rscript -e 'library(jsonlite)'")) GTEST_SKIP() << "R or its package jsonlite is not installed";
  EXPECT_NE(run_blocks("r", "Rscript").find("sppm"), std::string::npos);
}

}  // namespace
}  // namespace etendue
