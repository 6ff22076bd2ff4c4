#include "experiments/harness/report.h"

#include "experiments/harness/charts.h"
#include "experiments/harness/rate_report.h"
#include "experiments/harness/ratios.h"
#include "experiments/harness/report_html.h"
#include "experiments/harness/report_images.h"
#include "experiments/harness/tables.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace etendue {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t image_budget_bytes = 24 << 20;
constexpr const char* written_list = "report.files";  // what the last report wrote: the only files the next one may remove

// A reader never meets half a file: it is written beside its name and renamed.
void write_whole(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  const fs::path beside = path.string() + ".part";
  {
    std::ofstream out(beside, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    if (!out.flush()) {
      std::error_code ignored;
      fs::remove(beside, ignored);
      throw Error(Location{path.string()}, "cannot write the report here; expected a writable directory with space left");
    }
  }
  fs::rename(beside, path);
}

std::string read_small(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Files of a log are named relative to its directory.
void resolve(std::string& file, const fs::path& directory) {
  if (!file.empty() && fs::path(file).is_relative()) file = (directory / file).lexically_normal().string();
}

}  // namespace

RunLog read_resolved_log(const std::string& directory) {
  const fs::path path = fs::path(directory) / "runs.jsonl";
  if (!fs::is_regular_file(path))
    throw Error(Location{directory}, "no runs.jsonl here; expected a directory that `etendue run` wrote");
  RunLog log = read_log(path.string());
  for (CellRecord& cell : log.cells) {
    resolve(cell.image, directory);
    resolve(cell.strip, directory);
  }
  for (ReferenceRecord& reference : log.references) resolve(reference.file, directory);
  for (ClaimRecord& record : log.claims)
    if (record.stress) resolve(record.stress->picture, directory);
  return log;
}

namespace {

// Directories as a reader may type them: relative ones as they are, of others the last part.
std::string shown_name(const std::string& directory) {
  fs::path path = fs::path(directory).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.is_absolute() ? path.filename().string() : path.string();
}

// As logged, and what lies beside older logs.
std::vector<std::pair<std::string, std::string>> find_experiments(const RunLog& log,
                                                                  const std::vector<std::string>& directories) {
  constexpr std::uintmax_t largest = 64 << 10;
  std::vector<std::pair<std::string, std::string>> found;
  const auto add = [&](std::pair<std::string, std::string> experiment) {
    const auto same = [&](const auto& other) { return other.second == experiment.second; };
    if (std::none_of(found.begin(), found.end(), same)) found.push_back(std::move(experiment));
  };
  for (const ManifestRecord& manifest : log.manifests)
    if (!manifest.experiment.empty()) add({manifest.file.empty() ? nameless_experiment : manifest.file, manifest.experiment});
  for (const std::string& directory : directories) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(directory))
      if (entry.is_regular_file() && entry.path().extension() == ".toml" && entry.file_size() <= largest)
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) add({file.filename().string(), read_small(file)});
  }
  return found;
}

// Merging keeps one reference a scene: which scenes had different ones?
std::vector<std::string> conflicting_scenes(const RunLog& merged, const std::vector<RunLog>& logs) {
  std::vector<std::string> scenes;
  for (const ReferenceRecord& kept : merged.references) {
    const auto differs = [&](const ReferenceRecord& other) {
      return other.scene == kept.scene &&
             (other.scene_hash != kept.scene_hash || other.width != kept.width || other.height != kept.height);
    };
    if (std::any_of(logs.begin(), logs.end(),
                    [&](const RunLog& log) { return std::any_of(log.references.begin(), log.references.end(), differs); }))
      scenes.push_back(kept.scene);
  }
  return scenes;
}

class Output {
 public:
  explicit Output(fs::path directory) : directory_(std::move(directory)) {}

  void write(const std::string& name, const std::string& text) {
    write_whole(directory_ / name, text);
    names_.push_back(name);
  }

  // Removes what an earlier report left and this one did not write, and notes what was written.
  std::vector<std::string> finish() {
    const std::set<std::string> fresh(names_.begin(), names_.end());
    std::istringstream old(read_small(directory_ / written_list));
    for (std::string name; std::getline(old, name);) {
      const fs::path path(name);
      const bool below = path.is_relative() && std::find(path.begin(), path.end(), fs::path("..")) == path.end();
      std::error_code ignored;
      if (below && !name.empty() && !fresh.contains(name) && fs::is_regular_file(directory_ / path))
        fs::remove(directory_ / path, ignored);
    }
    std::string list;
    for (const std::string& name : names_) list += name + "\n";
    write_whole(directory_ / written_list, list);
    std::vector<std::string> paths;
    for (const std::string& name : names_) paths.push_back((directory_ / name).string());
    return paths;
  }

 private:
  fs::path directory_;
  std::vector<std::string> names_;
};

std::string formatted(const Table& table, const std::string& format) {
  if (format == "md") return to_markdown(table);
  if (format == "csv") return to_csv(table);
  return to_tex(table);
}

}  // namespace

std::vector<std::string> write_report(const std::vector<std::string>& directories, const std::string& output,
                                      const ReportOptions& options) {
  const std::vector<std::string> formats{"md", "csv", "tex"};
  for (const std::string& format : options.table_formats)
    if (std::find(formats.begin(), formats.end(), format) == formats.end())
      throw Error(unknown_name("table format", format, formats));
  std::vector<RunLog> logs;
  for (const std::string& directory : directories) logs.push_back(read_resolved_log(directory));
  const RunLog log = merge_logs(logs);
  ReportData data = arrange(log);
  data.conflicts = conflicting_scenes(log, logs);
  PageContent content;
  content.rates = fit_rates(data);
  content.tables = report_tables(data, image_statistics(data));
  if (const auto ratios = find_ratios(data); !ratios.empty())
    content.tables.insert(content.tables.begin(), ratios_table(ratios));
  if (!content.rates.empty()) content.tables.insert(content.tables.begin(), rates_table(content.rates));
  content.images = page_images(data, image_budget_bytes);
  for (const std::string& directory : directories) content.directories.push_back(shown_name(directory));
  content.experiments = find_experiments(log, directories);

  Output out(output.empty() ? fs::path(".") : fs::path(output));
  for (const Table& table : content.tables) {
    if (table.rows.empty() && table.name != "failures") continue;  // that there are none is an answer there
    for (const std::string& format : options.table_formats)
      out.write("tables/" + table.name + "." + format, formatted(table, format));
  }
  for (const Figure& figure : file_figures(data)) out.write("charts/" + figure.name + ".svg", to_svg(figure));
  for (const Figure& figure : rate_figures(content.rates)) out.write("charts/" + figure.name + ".svg", to_svg(figure));
  out.write("report.html", report_page(data, content));
  return out.finish();
}

}  // namespace etendue
