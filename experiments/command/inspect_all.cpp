// `etendue inspect --all`: which scene files below a folder can be read, which of them by approximation only, and what keeps
// the others out.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>

namespace etendue {

namespace {

namespace fs = std::filesystem;

struct Row {
  std::string file, outcome;  // outcome: loads, approximate or fails
  std::string reason;         // the first that keeps it from loading exactly
  std::size_t warnings = 0;
};

// Files come in an order that does not depend on the disk.
std::vector<std::string> scene_files_below(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw Error(Location{"--all"}, fmt::format("'{}' is no folder; expected one that holds scene files", folder));
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
    if (entry.is_regular_file(error) && is_scene_file(entry.path().string())) files.push_back(entry.path().string());
  std::ranges::sort(files);
  return files;
}

Row inspect_one(const std::string& path, const std::string& folder, const SceneReading& reading) {
  Row row{fs::path(path).lexically_relative(folder).string(), "loads", "", 0};
  try {
    row.warnings = load_scene(path, {"command line"}, {.confined = reading.confined}).warnings.size();
    return row;
  } catch (const Error& e) {
    row.reason = e.what();
  }
  try {
    row.warnings = load_scene(path, {"command line"}, {.confined = reading.confined, .approximate = true}).warnings.size();
    row.outcome = "approximate";
  } catch (const Error& e) {
    row.outcome = "fails";
    row.reason = e.what();
  }
  if (row.reason.starts_with(folder)) row.reason.erase(0, folder.size() + (folder.ends_with('/') ? 0 : 1));
  return row;
}

// Cuts off the place, and what the message says is there instead.
std::string kind_of(const std::string& reason) {
  const std::size_t end = reason.find(": ");
  const bool has_place = end != std::string::npos && end > 0 && std::isdigit(static_cast<unsigned char>(reason[end - 1]));
  const std::string message = has_place ? reason.substr(end + 2) : reason;
  return message.substr(0, message.find(';'));
}

std::string cut(const std::string& text, std::size_t most) { return text.size() <= most ? text : text.substr(0, most) + "..."; }

}  // namespace

int inspect_all(const InspectCommand& command) {
  const std::string folder = fs::path(command.scene).lexically_normal().string();
  const std::vector<std::string> files = scene_files_below(folder);
  std::map<std::string, std::size_t> outcomes, reasons;
  Json rows = Json::array();
  Console console;
  exit_on_interrupt("\ninterrupted\n");
  std::size_t width = 0;
  for (const std::string& file : files) width = std::max(width, fs::path(file).lexically_relative(folder).string().size());
  for (const std::string& file : files) {
    console.status(file);
    const Row row = inspect_one(file, folder, command.reading);
    console.clear_status();
    ++outcomes[row.outcome];
    if (!row.reason.empty()) ++reasons[kind_of(row.reason)];
    if (command.json)
      rows.push_back({{"file", row.file}, {"outcome", row.outcome}, {"reason", row.reason}, {"warnings", row.warnings}});
    else
      fmt::print("{:<{}}  {:<11}  {}\n", row.file, width, row.outcome,
                 row.reason.empty() ? fmt::format("{} warnings", row.warnings) : cut(row.reason, 160));
  }
  if (command.json) {
    fmt::print("{}\n", dump(Json{{"files", rows}, {"outcomes", outcomes}, {"reasons", reasons}}, 2));
    return 0;
  }
  fmt::print("\n{} scene files: {} load, {} load with --approximate, {} fail\n", files.size(), outcomes["loads"],
             outcomes["approximate"], outcomes["fails"]);
  std::vector<std::pair<std::size_t, std::string>> sorted;
  for (const auto& [reason, count] : reasons) sorted.emplace_back(count, reason);
  std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [count, reason] : sorted) fmt::print("{:>5}  {}\n", count, cut(reason, 160));
  return 0;
}

}  // namespace etendue
