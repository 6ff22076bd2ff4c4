#include "experiments/report/results/results.h"

#include "experiments/config/config_tree.h"
#include "experiments/kind.h"
#include "experiments/report/report.h"
#include "experiments/report/report_text.h"
#include "experiments/report/results/changes.h"
#include "experiments/report/results/quotes.h"
#include "framework/core/error.h"
#include "framework/core/units.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

namespace etendue {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> documents(const fs::path& root) {
  std::vector<fs::path> found{root / "README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  std::sort(found.begin() + 1, found.end());
  return found;
}

// "first-light/charts/error-time.svg", wherever a document names results/ before it.
void add_shown_charts(std::set<std::string>& charts, const std::string& text) {
  constexpr std::string_view before = "](results/", deeper = "](../results/";
  for (std::size_t at = 0; (at = text.find("](", at)) != std::string::npos; at += 2) {
    const std::string_view rest = std::string_view(text).substr(at);
    const std::size_t skipped = rest.starts_with(before) ? before.size() : rest.starts_with(deeper) ? deeper.size() : 0;
    const std::string_view path = rest.substr(skipped, rest.find(')') - skipped);
    if (skipped > 0 && path.ends_with(".svg")) charts.emplace(path);
  }
}

// "AMD EPYC, family 25, model 17".
std::string processor_text(const ManifestRecord& manifest) {
  return fmt::format("{}, family {}, model {}", manifest.cpu, manifest.cpu_family, manifest.cpu_model);
}

std::string in_row(std::string text) {
  std::ranges::replace(text, '|', '/');
  return text;
}

// Joins what the parts of a merged log say, each once.
template <class Text>
std::string of_manifests(const RunLog& log, std::string_view separator, const Text& text) {
  std::set<std::string> texts;
  for (const ManifestRecord& manifest : log.manifests)
    if (const std::string one = std::invoke(text, manifest); !one.empty()) texts.insert(one);
  return in_row(joined(texts, separator));
}

constexpr std::string_view page_name = "results/README.md";
constexpr std::string_view page_head = R"(# Results

Each row is an experiment of `experiments/` by the same name, its answer as its log gives it. `./etendue results` runs them
again and writes this page; [docs/results.md](../docs/results.md) discusses them. The last column counts the commits since the
log's that touched what the experiment measures: its file, the code of methods and structures, and that which times them. It
says so of the day on which this page was written; `./etendue results --dry-run` says it of today.
Tables of more than 39 kB are not kept here; `./etendue report results/NAME` writes all of them.

| log | question | answer | commit | date | processor | instruction set | time it took | code since |
|---|---|---|---|---|---|---|---|---|)";

// A row for each experiment, not padded: answers are long.
std::string page_text(const fs::path& root, const std::map<std::string, LogAnswers>& answers, const CodeSince& since) {
  std::string text(page_head);
  for (const auto& [folder, answer] : answers) {
    const fs::path file = root / "experiments" / (folder + ".toml");
    const double seconds = answer.log.took_s;
    text += fmt::format("\n| [{0}]({0}/tables/) | {1} | {2} | {3} | {4} | {5} | {6} | {7} | {8} |", folder,
                        in_row(is_file(file.string()) ? question_of(read_file(file.string())) : ""), in_row(answer.answer),
                        of_manifests(answer.log, ", ", &ManifestRecord::commit),
                        of_manifests(answer.log, ", ", &ManifestRecord::date), of_manifests(answer.log, "; ", processor_text),
                        of_manifests(answer.log, ", ", &ManifestRecord::isa), seconds > 0 ? format_seconds(seconds) : "–",
                        since(folder, answer.log));
  }
  return text + "\n";
}

constexpr std::string_view moved_begin = "<!--moved-->", moved_end = "<!--/moved-->";

// The table over all experiments takes the place of what stands between its markers, where a document has them.
std::string fill_moved(const std::string& file, std::string text, const std::map<std::string, LogChanges>& moved) {
  const std::size_t begin = text.find(moved_begin), end = text.find(moved_end);
  if (begin == std::string::npos) return text;
  if (end == std::string::npos || end < begin)
    throw Error(location_at(file, text, begin), fmt::format("a table without its end; expected {}", moved_end));
  const std::string table = to_markdown(moved_table(moved));
  const std::size_t inside = begin + moved_begin.size();
  return text.replace(inside, end - inside, "\n" + table.substr(table.find("\n\n") + 2));
}

// Answers what a folder's log changed, if there was one before. Throws Error where that is said of another log.
std::optional<LogChanges> changes_in(const fs::path& folder, const RunLog& log) {
  const std::string file = (folder / changes_file).string();
  if (!is_file(file)) return std::nullopt;
  LogChanges changes = read_changes(file, read_file(file));
  if (changes.to != commit_of(log))
    throw Error(Location{file},
                fmt::format("it is about a log of {}; expected {}, as `./etendue results --derive --before DIR` compares them",
                            changes.to, commit_of(log)));
  return changes;
}

}  // namespace

std::string commit_of(const RunLog& log) { return log.manifests.empty() ? "?" : log.manifests.back().commit; }

std::vector<std::string> result_folders(const std::string& root) {
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(fs::path(root) / "results"))
    if (is_file((entry.path() / "runs.jsonl").string())) folders.push_back(entry.path().filename().string());
  std::ranges::sort(folders);
  return folders;
}

std::string question_of(const std::string& experiment_text) {
  std::string comment;
  for (const std::string& line : split(experiment_text, "\n")) {
    if (!line.starts_with('#')) break;
    comment += line.substr(std::min(line.find_first_not_of("# "), line.size())) + " ";
  }
  const std::size_t mark = comment.find('?');
  if (mark == std::string::npos) return "";
  const std::size_t before = comment.rfind(". ", mark), begin = before == std::string::npos ? 0 : before + 2;
  return comment.substr(begin, mark + 1 - begin);
}

std::optional<std::string> output_of(const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += shell_word(word) + " ";
  FILE* const pipe = popen((line + "2>/dev/null").c_str(), "re");
  if (pipe == nullptr) return std::nullopt;
  std::string text;
  for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
  return pclose(pipe) == 0 ? std::optional(text) : std::nullopt;
}

std::string code_since(const std::string& root, const std::string& commit, const std::vector<std::string>& paths) {
  const std::string unknown = "not known";
  if (commit.empty() || commit.find_first_not_of("0123456789abcdef") != std::string::npos) return unknown;
  std::vector<std::string> command{"git", "-C", root, "log", "--format=%cs", commit + "..HEAD", "--"};
  command.insert(command.end(), paths.begin(), paths.end());
  const std::optional<std::string> dates = output_of(command);
  if (!dates) return unknown;
  const auto commits = static_cast<std::size_t>(std::ranges::count(*dates, '\n'));
  return commits == 0 ? "unchanged"
                      : fmt::format("{}, the last of {}", counted(commits, "commit"), dates->substr(0, dates->find('\n')));
}

CodeSince code_since_in_git(const std::string& root) {
  return [root](const std::string& folder, const RunLog& log) {
    const std::string name = fmt::format("experiments/{}.toml", folder), file = (fs::path(root) / name).string();
    if (!is_file(file)) return std::string("not known");
    std::vector<std::string> paths = kind_of(parse_config(read_config_text(file), file)).measures();
    paths.push_back(name);
    return code_since(root, commit_of(log), paths);
  };
}

// `report` writes these tables, and those too long for a reader: they would take a tenth of what is committed.
const std::set<std::string_view> left_to_report{"counters", "phases"};
constexpr std::size_t most_bytes = 39'000;

std::map<std::string, std::string> derived_files(const std::string& root, const CodeSince& since) {
  const fs::path top(root);
  std::map<std::string, std::string> files;
  std::set<std::string> charts;
  for (const fs::path& document : documents(top)) add_shown_charts(charts, read_file(document.string()));
  std::map<std::string, LogAnswers> answers;
  std::map<std::string, LogChanges> moved;
  for (const std::string& folder : result_folders(root)) {
    const LogAnswers& answer = answers[folder] = answers_of((top / "results" / folder).string());
    for (const Table& table : answer.tables) {
      std::string text = left_to_report.contains(table.name) ? "" : to_markdown(table);
      if (!text.empty() && text.size() <= most_bytes)
        files[fmt::format("results/{}/tables/{}.md", folder, table.name)] = std::move(text);
    }
    for (const Figure& figure : answer.figures)
      if (const std::string chart = fmt::format("{}/charts/{}.svg", folder, figure.name); charts.erase(chart) > 0)
        files["results/" + chart] = to_svg(figure);
    if (std::optional<LogChanges> changes = changes_in(top / "results" / folder, answer.log)) {
      files[fmt::format("results/{}/changes.md", folder)] = changes_page(*changes);
      moved[folder] = std::move(*changes);
    }
  }
  if (!charts.empty()) throw Error(fmt::format("a document shows results/{}, which no log gives", *charts.begin()));
  files[std::string(page_name)] = page_text(top, answers, since);
  const TableSource tables = [&](const std::string& folder, const std::string& name) -> const Table& {
    const auto found = answers.find(folder);
    if (found == answers.end()) throw Error(unknown_name("folder of results/", folder, result_folders(root)));
    std::vector<std::string> names;
    for (const Table& table : found->second.tables) {
      if (table.name == name) return table;
      names.push_back(table.name);
    }
    throw Error(unknown_name("table", name, names));
  };
  for (const fs::path& document : documents(top)) {
    const std::string path = document.lexically_relative(top).string();
    files[path] = fill_moved(path, fill_quotes(path, read_file(document.string()), tables), moved);
  }
  return files;
}

std::vector<std::string> left_over_files(const std::string& root, const std::map<std::string, std::string>& derived) {
  std::vector<std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(root) / "results")) {
    const std::string folder = entry.path().parent_path().filename().string();
    const std::string path = entry.path().lexically_relative(root).string();
    const bool is_derived = folder == "tables" || folder == "charts" || entry.path().filename() == "changes.md";
    if (entry.is_regular_file() && is_derived && !derived.contains(path)) left.push_back(path);
  }
  std::ranges::sort(left);
  return left;
}

}  // namespace etendue
