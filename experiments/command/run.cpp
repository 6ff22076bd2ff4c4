#include "experiments/run/run.h"

#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/kind.h"
#include "experiments/report/report_text.h"
#include "experiments/run/run_directory.h"
#include "framework/core/units.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <filesystem>
#include <map>
#include <vector>

namespace etendue {

namespace {

// Prints cells on stdout, one a line, with what an earlier run made of them.
void print_plan(const RunPlan& plan, Console& console) {
  std::map<CellName, std::string> earlier;
  if (!plan.fresh) {
    const RunLog log = read_directory_log(plan.directory);
    for (const CellRecord& cell : log.cells) earlier[cell.cell] = cell.status;
    for (const auto& record : log.records) earlier[record->cell] = record->status;
  }
  std::size_t done = 0;
  for (const Cell& cell : plan.cells) {
    const auto found = earlier.find(cell.name);
    const std::string status = found == earlier.end() ? "" : "  [" + found->second + "]";
    if (status == "  [done]") ++done;
    fmt::print("{}{}\n", cell.name.key(), status);
  }
  const std::size_t left = plan.cells.size() - done;
  if (plan.config.structures)
    console.line(fmt::format("{} timed on {}", counted(plan.config.accels.size(), "structure"),
                             counted(plan.config.scenes.size(), "scene")));
  const std::string cells = plan.cells.empty() ? "" : fmt::format("{}, {} to run; ", counted(plan.cells.size(), "cell"), left);
  console.line(fmt::format("{}into {}", cells, plan.directory));
  if (const std::string effort = plan.config.kind->effort(plan.config); left > 0 && !effort.empty())
    console.line("each cell: " + effort);
  if (left > 0 && plan.config.budget.time_s)
    console.line(fmt::format("all of them: about {}, and what references, structures and metrics take",
                             format_seconds(static_cast<double>(left) * *plan.config.budget.time_s)));
}

// Names directories with their numbers of files, then the page, which is where a reader begins.
void print_files(const std::vector<std::string>& files, Console& console) {
  std::map<std::string, std::size_t> directories;
  std::string page;
  for (const std::string& file : files) {
    if (file.ends_with(".html"))
      page = file;
    else
      ++directories[std::filesystem::path(file).parent_path().string()];
  }
  for (const auto& [directory, count] : directories) console.line(fmt::format("{}/: {} files", directory, count));
  console.line(page);
}

}  // namespace

std::map<std::string, std::string> experiment_files() {
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  std::map<std::string, std::string> files;
  for (const std::filesystem::path& place :
       {std::filesystem::path(), program, program.parent_path(), program.parent_path() / "share/etendue"})
    for (const auto& entry : std::filesystem::directory_iterator(place / "experiments", ignored))
      if (entry.path().extension() == ".toml") files.emplace(entry.path().stem().string(), entry.path().string());
  return files;
}

namespace {

// Throws Error with the nearest names.
std::string find_experiment(const std::string& name) {
  const std::map<std::string, std::string> files = experiment_files();
  if (const auto found = files.find(name); found != files.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.first);
  throw Error(Location{"run"},
              unknown_name("experiment", name, names) + "; expected a .toml file, or the name of one in experiments/");
}

}  // namespace

int stress_command(RunCommand command) {
  command.options.experiment = find_experiment("stress");
  return run_command(command);
}

int run_command(const RunCommand& command) {
  Console console;
  RunOptions options = command.options;
  if (!is_file(options.experiment) && options.experiment.find_first_of("./") == std::string::npos)
    options.experiment = find_experiment(options.experiment);
  RunPlan plan = plan_run(options);
  if (command.dry_run) {
    print_plan(plan, console);
    return 0;
  }
  plan.threads = available_threads(plan.threads, console);
  exit_on_interrupt("\ninterrupted; the same command goes on from here\n");
  if (plan.shard.count > 1)
    console.line(fmt::format("shard {} of {}: {} cells, into {}", plan.shard.index, plan.shard.count, plan.cells.size(),
                             plan.directory));
  ConsoleRunObserver observer(console);
  const RunSummary summary = execute_run(plan, observer);
  console.clear_status();
  fmt::print("{}", wrapped(summary.table, 100));  // the prose: tables are no wider
  print_files(summary.report_files, console);
  const std::string cells = plan.cells.empty() ? ""
                                               : fmt::format("{} done, {} failed, {} done before; ",
                                                             counted(summary.done, "cell"), summary.failed, summary.skipped);
  console.line(cells + plan.directory);
  if (summary.disagreements > 0) console.warning(fmt::format("{} answers of structures are wrong", summary.disagreements));
  for (const std::string& note : summary.notes) console.warning(note);
  for (const std::string& finding : summary.findings) console.warning(finding);
  return summary.failed > 0 || summary.disagreements > 0 || !summary.findings.empty() ? 1 : 0;
}

}  // namespace etendue
