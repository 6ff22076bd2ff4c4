// The kind of experiment of docs/adding-a-method.md does what the page says, as the page has it.
#include "tests/unit/example_kind.h"
#include "experiments/report/report.h"
#include "tests/places.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/silent_observer.h"

#include <gtest/gtest.h>

#include <fstream>

namespace etendue {
namespace {

TEST(ExampleKind, StandsInTheDocsAsItIsCompiled) {
  const std::string page = read_text_file(std::string(project_folder) + "docs/adding-a-method.md");
  const std::string code = read_text_file(std::string(project_folder) + "tests/unit/example_kind.h");
  EXPECT_NE(page.find("```cpp\n" + code + "```"), std::string::npos);
  EXPECT_LE(std::count(code.begin(), code.end(), '\n'), 100);
}

TEST(ExampleKind, RunsLogsAndReports) {
  static const LoadingKind kind;
  add_experiment_kind(kind);
  const std::filesystem::path directory =
      std::filesystem::temp_directory_path() / ("etendue-example-kind-" + std::to_string(getpid()));
  std::filesystem::create_directories(directory);
  std::ofstream(directory / "loading.toml") << "scenes = [\"builtin:cornell-box\"]\n[loading]\nrepetitions = 3\n";
  RunOptions options;
  options.experiment = (directory / "loading.toml").string();
  options.out = (directory / "out").string();
  SilentObserver observer;
  const RunSummary first = execute_run(plan_run(options), observer);
  EXPECT_EQ(first.done, 1u);
  EXPECT_EQ(kind_of(parse_config("scenes = []", "x.toml")).keys().size(), 0u) << "images stay what is asked for by default";
  EXPECT_NE(first.table.find("cornell-box"), std::string::npos) << first.table;
  EXPECT_EQ(execute_run(plan_run(options), observer).skipped, 1u) << "it is resumed";
  const RunLog log = read_log((directory / "out/runs.jsonl").string());
  ASSERT_EQ(records_of<LoadingRecord>(log).size(), 1u);
  EXPECT_GT(records_of<LoadingRecord>(log)[0]->triangles, 10u);
  EXPECT_TRUE(std::filesystem::exists(directory / "out/tables/loading.csv"));
  options.overrides = {"budget={ samples = 1 }"};
  EXPECT_THROW(plan_run(options), Error) << "a key that would change nothing";
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace etendue
