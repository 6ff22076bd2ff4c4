#include "experiments/report/report.h"

#include "experiments/kind.h"
#include "experiments/log/products.h"
#include "experiments/log/trust.h"
#include "experiments/report/declared.h"
#include "experiments/report/page/html.h"
#include "experiments/report/rates.h"
#include "experiments/report/ratios.h"
#include "experiments/report/regret.h"
#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "framework/core/error.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sstream>

namespace etendue {
namespace fs = std::filesystem;
namespace {

RunLog read_directory(const std::string& directory) {
  const fs::path path = fs::path(directory) / "runs.jsonl";
  if (!is_file(path.string()))
    throw Error(Location{directory}, "no runs.jsonl here; expected a directory that `etendue run` wrote");
  return read_log(path.string());
}

// Calls change(name) for every file that the log names.
template <class Change>
void change_files(RunLog& log, const Change& change) {
  for (CellRecord& cell : log.cells) {
    change(cell.image);
    change(cell.strip);
  }
  for (ReferenceRecord& reference : log.references) change(reference.file);
  for (const auto& record : log.records)
    if (const KindRecord::File file = record->file(); file.path) change(*file.path);
}

// Files of a log are named relative to its directory.
void resolve_files(RunLog& log, const fs::path& directory) {
  change_files(log, [&](std::string& file) {
    if (!file.empty() && fs::path(file).is_relative()) file = (directory / file).lexically_normal().string();
  });
}

// Nobody held the files against the log, so they are left out.
void forget_files(RunLog& log) {
  change_files(log, [](std::string& file) { file.clear(); });
}

// A log that was kept alone, as those under results/ are, is believed without the files that it names.
bool is_alone(RunLog log, const fs::path& directory) {
  bool any = false, here = false;
  change_files(log, [&](const std::string& file) {
    any = any || !file.empty();
    here = here || (!file.empty() && is_file((directory / file).string()));
  });
  return any && !here;
}

// Directories as a reader may type them: relative ones as they are, of others the last part.
std::string shown_name(const std::string& directory) {
  fs::path path = fs::path(directory).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.is_absolute() ? path.filename().string() : path.string();
}

// The experiments that the log holds, each text once.
std::vector<std::pair<std::string, std::string>> find_experiments(const RunLog& log) {
  std::vector<std::pair<std::string, std::string>> found;
  for (const ManifestRecord& manifest : log.manifests) {
    const auto same = [&](const auto& other) { return other.second == manifest.experiment; };
    if (!manifest.experiment.empty() && std::ranges::none_of(found, same))
      found.emplace_back(manifest.file.empty() ? nameless_experiment : manifest.file, manifest.experiment);
  }
  return found;
}

// Merging keeps one reference and one version of a scene: which scenes had different ones?
std::vector<std::string> conflicting_scenes(const RunLog& merged, const std::vector<RunLog>& logs) {
  std::vector<std::string> scenes;
  for (const ReferenceRecord& kept : merged.references) {
    const auto differs = [&](const ReferenceRecord& other) {
      return other.scene == kept.scene && (other.scene_hash != kept.scene_hash || other.width != kept.width ||
                                           other.height != kept.height || other.stamp != kept.stamp);
    };
    const auto has_other = [&](const RunLog& log) { return std::ranges::any_of(log.references, differs); };
    if (std::ranges::any_of(logs, has_other)) scenes.push_back(kept.scene);
  }
  for (const SceneRecord& kept : merged.scenes) {
    const auto has_other = [&](const RunLog& log) {
      const SceneRecord* own = log.scene(kept.scene);
      return own != nullptr && own->hash != kept.hash;
    };
    if (std::ranges::any_of(logs, has_other)) index_in(scenes, kept.scene);
  }
  return scenes;
}

// Merging keeps one of each cell, that of the last directory.
std::vector<std::string> repeated_cells(const std::vector<RunLog>& logs, const std::vector<std::string>& directories) {
  std::vector<std::string> notes;
  std::set<CellName> known;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    std::size_t repeated = 0;
    for (const CellRecord& record : logs[i].cells) repeated += !known.insert(record.cell).second;
    for (const auto& record : logs[i].records) repeated += !known.insert(record->cell).second;
    if (repeated > 0)
      notes.push_back(
          fmt::format("{}: takes the place of {} of the directories before it", directories[i], counted(repeated, "cell")));
  }
  return notes;
}

// --- the files of a report ---

using FileList = std::map<std::string, FileStamp>;
constexpr const char* written_list = "report.files";  // what the last report wrote: nothing else may be removed

// A line for each file with its stamp and name, then the checksum of those lines.
std::string list_text(const FileList& files) {
  std::string text;
  for (const auto& [name, stamp] : files) text += fmt::format("{} {} {}\n", stamp.hash, stamp.bytes, name);
  return text + hash_text(text) + "\n";
}

// nullopt where the list is not as it was written.
std::optional<FileList> read_list(const std::string& all) {
  FileList files;
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
    if (!is_file(path_of(written_list))) return;
    if (auto list = read_list(read_file(path_of(written_list))))
      old_ = std::move(*list);
    else
      notes_.push_back(path_of(written_list) + " was changed since it was written: what an earlier report left stays");
    for (const auto& [name, stamp] : old_)
      if (const std::string path = path_of(name); is_file(path))
        if (const std::string wrong = difference(path, stamp); !wrong.empty())
          notes_.push_back(fmt::format("{} was changed since it was written ({}); it is written anew", path, wrong));
  }

  void write(const std::string& name, const std::string& text) {
    const std::string path = path_of(name);
    written_[name] = stamp_of(text);
    if (difference(path, written_[name]).empty()) return;  // to flush what is there already would take as long
    make_folders(fs::path(path).parent_path().string());
    write_whole_file(path, text);
  }

  // Removes what an earlier report left and this one did not write, and notes what was written.
  Report finish() {
    std::error_code ignored;
    for (const auto& [name, stamp] : old_)
      if (!written_.contains(name) && is_file(path_of(name))) fs::remove(path_of(name), ignored);
    write_whole_file(path_of(written_list), list_text(written_));
    Report report{{}, {}, std::move(notes_)};
    for (const auto& [name, stamp] : written_) report.files.push_back(path_of(name));
    return report;
  }

 private:
  std::string path_of(const std::string& name) const { return (directory_ / name).string(); }

  fs::path directory_;
  FileList old_, written_;
  std::vector<std::string> notes_;
};

// --- what a log tells ---

using Formatter = std::string (*)(const Table&);
const std::map<std::string, Formatter> formatters{{"md", to_markdown}, {"csv", to_csv}, {"tex", to_tex}};

// Tells what the experiment predicts of its images, and what methods declare of themselves.
KindReport predictions_report(const ReportData& data) {
  const std::vector<FittedRate> rates = fit_rates(data);
  Predictions predictions = exponent_predictions(rates);
  predictions.add(ratio_predictions(data));
  predictions.add(image_bias_predictions(data));
  KindReport report{.answer = predictions_answer(predictions), .id = "predictions", .heading = "Predictions"};
  if (!predictions.rows.empty()) {
    report.section = fmt::format("<p>{}</p>\n", escape_html(predictions_finding(predictions)));
    report.figures = {{"", rate_figures(rates)}};
  }
  predictions.add(bias_predictions(data));
  predictions.add(confidence_predictions(data));
  report.predictions = std::move(predictions);
  return report;
}

// Collects what needs no image. What an experiment was for comes first: what it predicts, then what its kind judges.
PageContent content_of(const ReportData& data) {
  PageContent content;
  content.parts.push_back(predictions_report(data));
  content.parts.push_back(regret_report(data));
  content.parts.push_back(settings_report(data));
  for (const ExperimentKind* kind : experiment_kinds()) content.parts.push_back(kind->report(*data.log));
  content.parts.push_back(structures_report(data));
  Predictions predictions;
  for (const KindReport& part : content.parts) predictions.add(part.predictions);
  content.tables.push_back(predictions_table(predictions));
  for (const KindReport& part : content.parts)
    content.tables.insert(content.tables.end(), part.tables.begin(), part.tables.end());
  const std::vector<Table> tables = report_tables(data);
  content.tables.insert(content.tables.end(), tables.begin(), tables.end());
  // That nothing failed is an answer.
  std::erase_if(content.tables, [](const Table& table) { return table.rows.empty() && table.name != "failures"; });
  return content;
}

std::vector<Figure> figures_of(const ReportData& data, const PageContent& content) {
  std::vector<Figure> figures = file_figures(data);
  for (const KindReport& part : content.parts)
    for (const FigureGroup& group : part.figures) figures.insert(figures.end(), group.figures.begin(), group.figures.end());
  std::erase_if(figures, [](const Figure& figure) { return figure.empty(); });  // where no cell is to be believed
  return figures;
}

// The purpose of an experiment comes first, as in content_of.
std::string answer_in(const ReportData& data, const PageContent& content) {
  for (const KindReport& part : content.parts)
    if (!part.answer.empty()) return part.answer;
  const std::string images = images_answer(data);
  return images.empty() ? structures_answer(*data.log) : images;
}

}  // namespace

RunLog read_resolved_log(const std::string& directory) {
  RunLog log = read_directory(directory);
  resolve_files(log, directory);
  return log;
}

LogAnswers answers_of(const std::string& directory) {
  RunLog log = read_directory(directory);
  forget_files(log);
  const ReportData data = arrange(log);
  const PageContent content = content_of(data);
  LogAnswers answers{content.tables, figures_of(data, content), answer_in(data, content), {}};
  answers.log = std::move(log);
  return answers;
}

Report write_report(const std::vector<std::string>& directories, const std::string& output, const ReportOptions& options) {
  for (const std::string& format : options.table_formats)
    require_name({}, "table format", format, std::vector<std::string>{"md", "csv", "tex"});
  std::vector<RunLog> logs = mapped(directories, read_directory);
  std::vector<std::string> alone;
  std::vector<std::string> findings = missing_parts(logs, directories, !options.of_a_run);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (options.check_files) {
      if (is_alone(logs[i], directories[i])) {
        forget_files(logs[i]);
        alone.push_back(fmt::format("{}: the log lies there without its images, so the page shows none", directories[i]));
      }
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
  content.directories = mapped(directories, shown_name);
  content.experiments = find_experiments(log);

  content.answer = answer_in(data, content);
  content.has_csv = contains(options.table_formats, "csv");

  Output out(output.empty() ? fs::path(".") : fs::path(output));
  ImagePlace place;
  place.directory = output;
  place.write_beside = [&](const std::string& name, const std::string& text) { out.write(name, text); };
  content.images = page_images(data, place);
  for (const Table& table : content.tables)
    for (const std::string& format : options.table_formats)
      out.write("tables/" + table.name + "." + format, formatters.at(format)(table));
  if (!data.finished().empty() && content.has_csv) out.write("tables/curves.csv", curves_csv(data));
  for (const Figure& figure : figures_of(data, content)) {
    out.write("charts/" + figure.name + ".svg", to_svg(figure));
    if (!options.latex || figure.panels.empty()) continue;  // a drawing is no chart of pgfplots
    out.write("latex/" + figure.name + ".tex", to_pgfplots(figure, figure.name + ".dat"));
    out.write("latex/" + figure.name + ".dat", pgfplots_data(figure));
  }
  out.write("report.html", report_page(data, content));
  Report report = out.finish();
  report.findings = std::move(findings);
  report.notes.insert(report.notes.end(), alone.begin(), alone.end());
  std::ranges::move(repeated_cells(logs, directories), std::back_inserter(report.notes));
  return report;
}

std::string curves_of(const std::vector<std::string>& directories) {
  const RunLog log = merge_logs(mapped(directories, read_directory));
  return curves_csv(arrange(log));
}

}  // namespace etendue
