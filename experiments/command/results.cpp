// `etendue results`: the experiments behind results/ again, and all that is derived from their logs.
#include "experiments/report/results/results.h"

#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/report/report.h"
#include "experiments/report/report_text.h"
#include "experiments/report/results/changes.h"
#include "framework/core/units.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <optional>

namespace etendue {

namespace {

namespace fs = std::filesystem;

std::string experiment_file(const std::string& name) { return "experiments/" + name + ".toml"; }

std::vector<std::string> experiment_names() {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("experiments", none))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  if (names.empty() || !fs::is_directory("results"))
    throw Error(Location{"results"},
                "no experiments/ and results/ here; expected etendue's source tree as the working directory");
  std::ranges::sort(names);
  return names;
}

// The folder where it runs, before what it found takes the place of what stands under results/.
fs::path work_folder(const std::string& name) { return fs::path("out/results") / name; }
fs::path committed_folder(const std::string& name) { return fs::path("results") / name; }

std::optional<RunLog> log_in(const fs::path& folder) {
  return is_file((folder / "runs.jsonl").string()) ? std::optional(read_log((folder / "runs.jsonl").string())) : std::nullopt;
}

// Prints what the last log says of itself, whether the code changed since, and the time to expect.
void print_estimate(const std::vector<std::string>& names, Console& console) {
  double sum = 0;
  std::size_t unknown = 0;
  const CodeSince since = code_since_in_git(".");
  for (const std::string& name : names) {
    const std::optional<RunLog> log = log_in(committed_folder(name));
    const std::string commit = log ? commit_of(*log) : "never";
    const double took = log ? log->took_s : 0;
    const std::string code = log ? since(name, *log) : "";
    fmt::print("{:<24} {:<20} {:<12} {}\n", name, commit, took > 0 ? format_seconds(took) : "?", code);
    sum += took;
    unknown += took == 0;
  }
  console.line(fmt::format("{} experiments: about {}{}", names.size(), format_seconds(sum),
                           unknown > 0 ? fmt::format(", and {} whose logs do not say how long they took", unknown) : ""));
}

// Those typed, else those that the last log was made with: its scenes may lie outside of this source tree.
std::vector<std::string> overrides_for(const std::string& name, const ResultsCommand& command) {
  const std::optional<RunLog> log = command.overrides.empty() ? log_in(committed_folder(name)) : std::nullopt;
  if (!log || log->manifests.empty()) return command.overrides;
  std::vector<std::string> overrides;
  const std::vector<std::string> words = shell_words(log->manifests.back().options);
  for (std::size_t i = 0; i + 1 < words.size(); i += 2)
    if (words[i] == "-o") overrides.push_back(words[i + 1]);
  return overrides;
}

int run_one(const std::string& name, const ResultsCommand& command, Console& console) {
  RunOptions options;
  options.experiment = experiment_file(name);
  options.out = work_folder(name).string();
  options.shard = command.shard;
  options.overrides = overrides_for(name, command);
  RunPlan plan = plan_run(options);
  if (plan.shard.count > 1) plan.directory += fmt::format("-shard-{}-of-{}", plan.shard.index, plan.shard.count);
  plan.threads = available_threads(plan.threads, console);
  console.line(fmt::format("{}: {} cells, into {}", name, plan.cells.size(), plan.directory));
  ConsoleRunObserver observer(console);
  const RunSummary summary = execute_run(plan, observer);
  console.clear_status();
  for (const std::string& finding : summary.findings) console.warning(finding);
  return summary.failed > 0 || summary.disagreements > 0 ? 1 : 0;
}

// Everything that lies in the folder and that the log names, pictures of failures among it.
void keep(const std::string& name, RunLog log) {
  const fs::path from = work_folder(name), to = committed_folder(name);
  fs::remove_all(to);
  fs::create_directories(to);
  fs::copy_file(from / "runs.jsonl", to / "runs.jsonl");
  for (const auto& record : log.records)
    if (const KindRecord::File file = record->file(); file.path != nullptr && !file.path->empty()) {
      fs::create_directories((to / *file.path).parent_path());
      fs::copy_file(from / *file.path, to / *file.path, fs::copy_options::overwrite_existing);
    }
}

// Compares two folders' logs and keeps in the second what moved.
LogChanges compare_folders(const fs::path& before, const fs::path& now) {
  const LogAnswers then = answers_of(before.string()), found = answers_of(now.string());
  return changes_between(commit_of(then.log), then.tables, commit_of(found.log), found.tables);
}

void keep_changes(const fs::path& folder, const LogChanges& changes) {
  write_whole_file((folder / changes_file).string(), to_text(changes));
}

// Puts what a run found in the place of what stands under results/, with what moved since the log there.
void collect(const std::string& name, Console& console) {
  const std::optional<RunLog> log = log_in(work_folder(name));
  if (!log || !log->finished) {
    console.warning(fmt::format("{}: its run did not finish; what stands under results/ stays", name));
    return;
  }
  std::optional<LogChanges> changes;
  if (log_in(committed_folder(name))) changes = compare_folders(committed_folder(name), work_folder(name));
  keep(name, *log);
  if (changes) keep_changes(committed_folder(name), *changes);
}

// Says what moved since the logs of an older results/, of which `before` is a copy.
void compare_with(const fs::path& before, Console& console) {
  if (!fs::is_directory(before)) throw Error(Location{before.string()}, "no such folder; expected a copy of an older results/");
  for (const std::string& folder : result_folders("."))
    if (const fs::path old = before / folder, now = committed_folder(folder);
        log_in(old) && read_file((old / "runs.jsonl").string()) != read_file((now / "runs.jsonl").string())) {
      keep_changes(now, compare_folders(old, now));
      console.line(fmt::format("{}: compared with {}", folder, old.string()));
    }
}

void write_derived(Console& console) {
  const auto files = derived_files(".", code_since_in_git("."));
  std::size_t written = 0;
  for (const auto& [path, text] : files)
    if (!is_file(path) || read_file(path) != text) {
      make_folders(fs::path(path).parent_path().string());
      write_whole_file(path, text);
      ++written;
    }
  const auto left = left_over_files(".", files);
  for (const std::string& path : left) fs::remove(path);
  console.line(fmt::format("{} files are derived from the logs: {} written, {} that nothing derives removed", files.size(),
                           written, left.size()));
}

}  // namespace

int results_command(const ResultsCommand& command) {
  Console console;
  const std::vector<std::string> known = experiment_names();
  for (const std::string& name : command.names) require_name({"results"}, "experiment", name, known);
  const std::vector<std::string>& names = command.names.empty() ? known : command.names;
  if (command.derive) {
    if (!command.before.empty()) compare_with(command.before, console);
    write_derived(console);
    return 0;
  }
  print_estimate(names, console);
  if (command.dry_run) return 0;
  refuse_changed_sources("results", make_manifest("", "", 1).commit);
  exit_on_interrupt("\ninterrupted; the same command goes on from here\n");
  int status = 0;
  for (const std::string& name : names) try {
      status = std::max(status, run_one(name, command, console));
    } catch (const Error& e) {  // such as a scene that this machine lacks: the others are run all the same
      if (names.size() == 1) throw;
      console.warning(fmt::format("{}: {}", name, e.what()));
      status = 1;
    }
  if (!command.shard.empty()) return status;  // the logs of all shards are needed first: `etendue report` merges them
  for (const std::string& name : names) collect(name, console);
  write_derived(console);
  return status;
}

}  // namespace etendue
