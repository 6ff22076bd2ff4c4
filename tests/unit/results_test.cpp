// What stands under results/ and what documents quote of it are what the logs say.
#include "experiments/report/results/results.h"
#include "experiments/log/log.h"
#include "experiments/run/run.h"
#include "framework/core/error.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"
#include "tests/places.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

namespace etendue {
namespace {

namespace fs = std::filesystem;

TEST(Results, AreWhatTheLogsGive) {
  const auto files = derived_files(project_folder);
  for (const auto& [path, text] : files) {
    ASSERT_TRUE(fs::exists(project_folder + path)) << path << " is missing: `./etendue results --derive` writes it";
    EXPECT_TRUE(read_file(project_folder + path) == text) << path << " differs: `./etendue results --derive` writes it";
  }
  EXPECT_EQ(left_over_files(project_folder, files), std::vector<std::string>());
}

TEST(Results, AreSmall) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(project_folder + std::string("results")))
    if (entry.is_regular_file()) bytes += entry.file_size();
  EXPECT_LE(bytes, 15u << 20);
}

TEST(Results, AFigureChangedByHandIsFound) {
  const fs::path root = fs::temp_directory_path() / fmt::format("etendue-results-{}", getpid());
  const fs::path folder = root / "results/first-light", log = folder / "runs.jsonl";
  fs::create_directories(folder);
  fs::create_directories(root / "docs");
  fs::copy_file(fs::path(project_folder) / "results/first-light/runs.jsonl", log);
  const auto write = [](const fs::path& path, const std::string& text) { write_whole_file(path.string(), text); };
  write(root / "README.md",
        "<!--= first-light/final seeds [cornell-box, path, sah] -->7<!--/-->\n![](results/first-light/charts/"
        "error-time-cornell-box-relmse.svg)\n");
  const auto files = derived_files(root.string());
  EXPECT_TRUE(files.at("README.md").starts_with("<!--= first-light/final seeds [cornell-box, path, sah] -->2<!--/-->\n"));
  EXPECT_TRUE(files.contains("results/first-light/tables/final.md"));
  EXPECT_TRUE(files.contains("results/first-light/charts/error-time-cornell-box-relmse.svg"));
  EXPECT_FALSE(files.contains("results/first-light/charts/error-time-lambert-sphere-relmse.svg")) << "no document shows it";
  EXPECT_NE(files.at("results/README.md").find("[first-light](first-light/tables/)"), std::string::npos);
  write(root / "docs/a.md", "![](../results/first-light/charts/none.svg)");
  EXPECT_THROW(derived_files(root.string()), Error);
  fs::remove(root / "docs/a.md");
  std::string text = read_file(log.string());
  text[text.find("\"time_s\":") + 9] = text[text.find("\"time_s\":") + 9] == '1' ? '2' : '1';
  write(log, text);
  EXPECT_THROW(derived_files(root.string()), Error) << "a line of the log that was changed";
  fs::remove_all(root);
}

TEST(Results, QuestionsAreFirstSentencesThatAsk) {
  EXPECT_EQ(question_of("# Which one\n# is it? It is.\ntitle = \"x\"\n"), "Which one is it?");
  EXPECT_EQ(question_of("# A first sentence. And a question?\n"), "And a question?");
  EXPECT_EQ(question_of("title = \"what?\"\n"), "");
}

TEST(Results, TakeNoRunFromChangedSources) {
  EXPECT_NO_THROW(refuse_changed_sources("out/x", "0123-dirty"));
  EXPECT_NO_THROW(refuse_changed_sources("results/x", "0123"));
  EXPECT_THROW(refuse_changed_sources("results/x", "0123-dirty"), Error);
  EXPECT_THROW(refuse_changed_sources("./a/results/x", "0123-dirty"), Error);
}

}  // namespace
}  // namespace etendue
