#include "experiments/report/report.h"

#include "experiments/kind.h"
#include "experiments/log/products.h"
#include "experiments/log/trust.h"
#include "experiments/report/charts.h"
#include "experiments/report/confidence.h"
#include "experiments/report/page/html.h"
#include "experiments/report/page/images.h"
#include "experiments/report/rate_report.h"
#include "experiments/report/ratios.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "framework/core/error.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

namespace etendue {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t image_budget_bytes = 24 << 20;
constexpr const char* written_list = "report.files";  // what the last report wrote: nothing else may be removed

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

namespace {

RunLog read_directory(const std::string& directory) {
  const fs::path path = fs::path(directory) / "runs.jsonl";
  if (!is_file(path.string()))
    throw Error(Location{directory}, "no runs.jsonl here; expected a directory that `etendue run` wrote");
  return read_log(path.string());
}

void resolve_files(RunLog& log, const std::string& directory) {
  for (CellRecord& cell : log.cells) {
    resolve(cell.image, directory);
    resolve(cell.strip, directory);
  }
  for (ReferenceRecord& reference : log.references) resolve(reference.file, directory);
  for (const auto& record : log.records)
    if (const KindRecord::File file = record->file(); file.path) resolve(*file.path, directory);
}

// Without the files that the log names, which nobody held against it.
void forget_files(RunLog& log) {
  for (CellRecord& cell : log.cells) {
    cell.image.clear();
    cell.strip.clear();
  }
  for (ReferenceRecord& reference : log.references) reference.file.clear();
}

}  // namespace

RunLog read_resolved_log(const std::string& directory) {
  RunLog log = read_directory(directory);
  resolve_files(log, directory);
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

// What a report wrote: a line for each file with its stamp and name, then the checksum of those lines.
std::string list_text(const std::map<std::string, FileStamp>& files) {
  std::string text;
  for (const auto& [name, stamp] : files) text += fmt::format("{} {} {}\n", stamp.hash, stamp.bytes, name);
  return text + hash_text(text) + "\n";
}

// nullopt where the list is not as it was written.
std::optional<std::map<std::string, FileStamp>> read_list(const fs::path& path) {
  std::map<std::string, FileStamp> files;
  const std::string all = read_small(path);
  std::istringstream lines(all);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    FileStamp stamp;
    std::string name;
    if (words >> stamp.hash >> stamp.bytes && words.get() == ' ' && std::getline(words, name)) files[name] = stamp;
  }
  return list_text(files) == all ? std::optional(files) : std::nullopt;
}

class Output {
 public:
  explicit Output(fs::path directory) : directory_(std::move(directory)) {
    std::error_code ignored;
    if (!fs::is_regular_file(directory_ / written_list, ignored)) return;
    if (auto list = read_list(directory_ / written_list)) {
      old_ = std::move(*list);
    } else {
      notes_.push_back(fmt::format("{} was changed since it was written: what an earlier report left stays",
                                   (directory_ / written_list).string()));
    }
    for (const auto& [name, stamp] : old_)
      if (fs::exists(directory_ / name, ignored))
        if (const std::string wrong = difference((directory_ / name).string(), stamp); !wrong.empty())
          notes_.push_back(
              fmt::format("{} was changed since it was written ({}); it is written anew", (directory_ / name).string(), wrong));
  }

  void write(const std::string& name, const std::string& text) {
    const fs::path path = directory_ / name;
    const FileStamp stamp = stamp_of(text);
    if (!difference(path.string(), stamp).empty()) {  // to flush what is there already would take as long
      make_folders(path.parent_path().string());
      write_whole_file(path.string(), text);
    }
    written_[name] = stamp;
  }

  // Removes what an earlier report left and this one did not write, and notes what was written.
  Report finish() {
    std::error_code ignored;
    for (const auto& [name, stamp] : old_)
      if (!written_.contains(name) && fs::is_regular_file(directory_ / name, ignored)) fs::remove(directory_ / name, ignored);
    write_whole_file((directory_ / written_list).string(), list_text(written_));
    Report report{{}, {}, std::move(notes_)};
    for (const auto& [name, stamp] : written_) report.files.push_back((directory_ / name).string());
    return report;
  }

 private:
  fs::path directory_;
  std::map<std::string, FileStamp> old_, written_;
  std::vector<std::string> notes_;
};

std::string formatted(const Table& table, const std::string& format) {
  if (format == "md") return to_markdown(table);
  if (format == "csv") return to_csv(table);
  return to_tex(table);
}

// What needs no image.
PageContent content_of(const ReportData& data) {
  PageContent content;
  content.rates = fit_rates(data);
  content.stated = exponent_predictions(content.rates);
  content.stated.add(ratio_predictions(find_ratios(data)));
  Predictions predictions = content.stated;
  predictions.add(bias_predictions(data));
  predictions.add(confidence_predictions(data));
  for (const ExperimentKind* kind : experiment_kinds()) {
    content.kinds.push_back(kind->report(*data.log));
    predictions.add(content.kinds.back().predictions);
  }
  content.tables.push_back(predictions_table(predictions));
  for (const KindReport& kind : content.kinds)
    content.tables.insert(content.tables.end(), kind.tables.begin(), kind.tables.end());
  const std::vector<Table> tables = report_tables(data);
  content.tables.insert(content.tables.end(), tables.begin(), tables.end());
  return content;
}

std::vector<Figure> figures_of(const ReportData& data, const PageContent& content) {
  std::vector<Figure> figures = file_figures(data);
  for (const KindReport& kind : content.kinds) figures.insert(figures.end(), kind.figures.begin(), kind.figures.end());
  const std::vector<Figure> rates = rate_figures(content.rates);
  figures.insert(figures.end(), rates.begin(), rates.end());
  return figures;
}

// What an experiment was for comes first: theory, then what its kind judges, then who leads where.
std::string finding_of(const ReportData& data, const PageContent& content) {
  if (std::string stated = predictions_finding(content.stated); !stated.empty()) return stated;
  for (const KindReport& kind : content.kinds) {
    if (!kind.answer.empty()) return kind.answer;
    if (!kind.findings.empty()) return kind.findings.front().second;
  }
  constexpr std::size_t most = 4;  // scenes: it is one sentence that a reader wants
  std::string text;
  const std::vector<SceneFindings> scenes = conclude(data).scenes;
  for (std::size_t i = 0; i < std::min(most, scenes.size()); ++i) {
    const Finding& first = scenes[i].findings.front();
    const std::size_t end = first.text.find(". ");
    text += fmt::format("{}{}: {}{}", text.empty() ? "" : " ", scenes[i].scene, first.lead,
                        end == std::string::npos ? first.text : first.text.substr(0, end + 1));
  }
  return scenes.size() > most ? fmt::format("{} And {} more scenes.", text, scenes.size() - most) : text;
}

// That nothing failed is an answer.
bool is_shown(const Table& table) { return !table.rows.empty() || table.name == "failures"; }

}  // namespace

LogAnswers answers_of(const std::string& directory) {
  RunLog log = read_directory(directory);
  forget_files(log);
  const ReportData data = arrange(log);
  PageContent content = content_of(data);
  LogAnswers answers{std::move(content.tables), figures_of(data, content), finding_of(data, content), {}};
  std::erase_if(answers.tables, [](const Table& table) { return !is_shown(table); });
  answers.log = std::move(log);
  return answers;
}

Report write_report(const std::vector<std::string>& directories, const std::string& output, const ReportOptions& options) {
  const std::vector<std::string> formats{"md", "csv", "tex"};
  for (const std::string& format : options.table_formats)
    if (std::find(formats.begin(), formats.end(), format) == formats.end())
      throw Error(unknown_name("table format", format, formats));
  std::vector<RunLog> logs;
  for (const std::string& directory : directories) logs.push_back(read_directory(directory));
  std::vector<std::string> findings = missing_parts(logs, directories, !options.of_a_run);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (options.check_files) {
      for (std::string& finding : distrust(logs[i], directories[i], !options.of_a_run)) findings.push_back(std::move(finding));
      resolve_files(logs[i], directories[i]);
    } else {
      forget_files(logs[i]);
    }
  }
  RunLog log = merge_logs(logs);
  if (options.check_files && logs.size() > 1)  // no shard has the images of all seeds
    for (ProductsRecord& record : missing_products(log)) add_products(log, std::move(record));
  ReportData data = arrange(log);
  data.conflicts = conflicting_scenes(log, logs);
  data.findings = findings;
  PageContent content = content_of(data);
  content.images = page_images(data, image_budget_bytes);
  for (const std::string& directory : directories) content.directories.push_back(shown_name(directory));
  content.experiments = find_experiments(log, directories);

  Output out(output.empty() ? fs::path(".") : fs::path(output));
  for (const Table& table : content.tables) {
    if (!is_shown(table)) continue;
    for (const std::string& format : options.table_formats)
      out.write("tables/" + table.name + "." + format, formatted(table, format));
  }
  for (const Figure& figure : figures_of(data, content)) out.write("charts/" + figure.name + ".svg", to_svg(figure));
  out.write("report.html", report_page(data, content));
  Report report = out.finish();
  report.findings = std::move(findings);
  return report;
}

}  // namespace etendue
