// What stands under results/ and what documents quote of it are what the logs say.
#include "experiments/report/results/results.h"
#include "experiments/kind.h"
#include "experiments/log/log.h"
#include "experiments/report/report_text.h"
#include "experiments/report/results/changes.h"
#include "experiments/report/verdicts.h"
#include "experiments/run/run.h"
#include "framework/core/error.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"
#include "tests/places.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>

namespace etendue {
namespace {

namespace fs = std::filesystem;

// Git's answer changes with each commit. So the text of the page that stands counts as git's on the day on which it was
// written.
CodeSince code_since_in_page(const std::string& root) {
  const std::string path = root + "/results/README.md";
  std::istringstream lines(fs::exists(path) ? read_file(path) : "");
  std::map<std::string, std::string> texts;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("| [") && line.ends_with(" |")) {
      line.resize(line.size() - 2);
      texts[line.substr(3, line.find(']') - 3)] = line.substr(line.rfind("| ") + 2);
    }
  return [texts = std::move(texts)](const std::string& folder, const RunLog&) {
    const auto found = texts.find(folder);
    return found == texts.end() ? std::string("not known") : found->second;
  };
}

TEST(Results, AreWhatTheLogsGive) {
  const auto files = derived_files(project_folder, code_since_in_page(project_folder));
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
  EXPECT_LE(bytes, 15500000u);
}

// A row of the page has them between bars.
std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  for (std::size_t begin = 2, end; (end = row.find(" |", begin)) != std::string::npos; begin = end + 3)
    cells.push_back(row.substr(begin, end - begin));
  return cells;
}

TEST(Results, AnswersAreShort) {
  std::istringstream lines(read_file(project_folder + std::string("results/README.md")));
  std::size_t rows = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| [")) continue;
    const std::vector<std::string> cells = cells_of(line);
    ASSERT_EQ(cells.size(), 9u) << line;
    EXPECT_NE(cells[2], "") << cells[0];
    EXPECT_LE(display_width(cells[2]), answer_width + 50) << cells[0];
    ++rows;
  }
  EXPECT_EQ(rows, result_folders(project_folder).size());
}

TEST(Results, CodeSinceACommitIsCountedByPaths) {
  const fs::path root = fs::temp_directory_path() / fmt::format("etendue-code-since-{}", getpid());
  fs::create_directories(root / "a");
  const auto git = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"git", "-C", root.string(), "-c", "user.name=a", "-c", "user.email=a@b.c"});
    return output_of(arguments);
  };
  if (!git({"init"})) GTEST_SKIP() << "no git here";
  const auto commit = [&](const char* path, const char* text) {
    write_whole_file((root / path).string(), text);
    EXPECT_TRUE(git({"add", "."}));
    EXPECT_TRUE(git({"commit", "--date=2026-01-02", "-m", "x"}));
    return git({"rev-parse", "--short=12", "HEAD"}).value_or("\n").substr(0, 12);
  };
  const std::string first = commit("a/x", "1"), second = commit("a/x", "2");
  commit("b_report.cpp", "1");
  const std::string folder = root.string();
  EXPECT_EQ(code_since(folder, first, {"a"}).substr(0, 22), "1 commit, the last of ");
  EXPECT_EQ(code_since(folder, second, {"a"}), "unchanged");
  EXPECT_EQ(code_since(folder, first, {"."}).substr(0, 23), "2 commits, the last of ");
  EXPECT_EQ(code_since(folder, second, {".", ":(exclude)*_report.*"}), "unchanged");
  EXPECT_EQ(code_since(folder, "0123456789ab", {"a"}), "not known");
  EXPECT_EQ(code_since(folder, second + "-dirty", {"a"}), "not known");
  EXPECT_EQ(code_since(folder, "--output=x", {"a"}), "not known");
  EXPECT_EQ(output_of({"etendue-no-such-program"}), std::nullopt);
  fs::remove_all(root);
}

TEST(Results, PathsThatExperimentsMeasureExist) {
  for (const ExperimentKind* kind : experiment_kinds())
    for (const std::string& path : kind->measures())
      EXPECT_TRUE(path.starts_with(":(exclude)") || fs::exists(project_folder + path)) << path;
}

TEST(Results, AFigureChangedByHandIsFound) {
  const fs::path root = fs::temp_directory_path() / fmt::format("etendue-results-{}", getpid());
  const fs::path folder = root / "results/photon-family", log = folder / "runs.jsonl";
  fs::create_directories(folder);
  fs::create_directories(root / "docs");
  fs::copy_file(fs::path(project_folder) / "results/photon-family/runs.jsonl", log);
  const auto write = [](const fs::path& path, const std::string& text) { write_whole_file(path.string(), text); };
  write(root / "README.md",
        "<!--= photon-family/final seeds [cornell-box, path] -->7<!--/-->\n![](results/photon-family/charts/"
        "error-time-cornell-box-relmse.svg)\n");
  const auto files = derived_files(root.string(), code_since_in_page(root.string()));
  EXPECT_TRUE(files.at("README.md").starts_with("<!--= photon-family/final seeds [cornell-box, path] -->3<!--/-->\n"));
  EXPECT_TRUE(files.contains("results/photon-family/tables/final.md"));
  EXPECT_TRUE(files.contains("results/photon-family/charts/error-time-cornell-box-relmse.svg"));
  EXPECT_FALSE(files.contains("results/photon-family/charts/error-time-two-rooms-relmse.svg")) << "no document shows it";
  EXPECT_NE(files.at("results/README.md").find("[photon-family](photon-family/tables/)"), std::string::npos);
  EXPECT_TRUE(files.at("results/README.md").ends_with(" | not known |\n")) << "no page said so before";
  write(root / "docs/a.md", "![](../results/photon-family/charts/none.svg)");
  EXPECT_THROW(derived_files(root.string(), code_since_in_page(root.string())), Error);
  write(root / "docs/a.md", "<!--moved-->7<!--/moved-->.");
  const LogChanges changes{"before", commit_of(read_log(log.string())), 10, 0, 0, 0, {}};
  write(folder / changes_file, to_text(changes));
  const auto with_changes = derived_files(root.string(), code_since_in_page(root.string()));
  EXPECT_NE(with_changes.at("docs/a.md").find("| photon-family | before |"), std::string::npos) << with_changes.at("docs/a.md");
  EXPECT_TRUE(with_changes.at("docs/a.md").ends_with("<!--/moved-->."));
  EXPECT_NE(with_changes.at("results/photon-family/changes.md").find(changes.sentence()), std::string::npos);
  write(folder / changes_file, to_text(LogChanges{"before", "another", 10, 0, 0, 0, {}}));
  EXPECT_THROW(derived_files(root.string(), code_since_in_page(root.string())), Error) << "what moved up to another log";
  write(folder / changes_file, to_text(changes) + " ");
  EXPECT_THROW(derived_files(root.string(), code_since_in_page(root.string())), Error) << "what moved, changed by hand";
  fs::remove(folder / changes_file);
  fs::remove(root / "docs/a.md");
  std::string text = read_file(log.string());
  text[text.find("\"time_s\":") + 9] = text[text.find("\"time_s\":") + 9] == '1' ? '2' : '1';
  write(log, text);
  EXPECT_THROW(derived_files(root.string(), code_since_in_page(root.string())), Error) << "a line of the log that was changed";
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
