// The tables that list records as they are, and the summary at the end of a run.
#include "experiments/report/confidence.h"
#include "experiments/report/rate_report.h"
#include "experiments/report/ratios.h"
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace etendue {
namespace {

TableCell words_or_none(const std::string& text) { return text.empty() ? TableCell{} : TableCell::words(text); }

}  // namespace

Table references_table(const ReportData& data) {
  Table table{"references", "References", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false},
                   {"source", "source", false},
                   {"size", "pixels"},
                   {"mse_floor", "own variance"},
                   {"floor_share", "of least mse"},
                   {"checks", "checks", false},
                   {"file", "file", false},
                   {"scene_hash", "", false, Audience::machines}};
  for (const ReferenceRecord& r : data.log->references) {
    const auto scene =
        std::find_if(data.scenes.begin(), data.scenes.end(), [&](const SceneData& s) { return s.reference == &r; });
    const double share = scene == data.scenes.end() ? 0 : floor_share(*scene);
    TableCell share_cell = share == 0 ? TableCell{} : TableCell::number(share, format_figure(100 * share) + " %");
    if (share > floor_share_limit) share_cell.text += " (above 1 %)";
    table.rows.push_back({words_or_none(r.scene), words_or_none(r.source),
                          TableCell::words(fmt::format("{}×{}", r.width, r.height)), TableCell::number(r.mse_floor), share_cell,
                          words_or_none(r.checks), words_or_none(std::filesystem::path(r.file).filename().string()),
                          words_or_none(r.scene_hash)});
  }
  return table;
}

Table expectations_table(const ReportData& data) {
  Table table{"expectations", "What the methods declare", {}, {}, {}, {}};
  table.columns = {{"integrator", "integrator", false},
                   {"bias", "bias", false},
                   {"mse_exponent", "exponent of MSE"},
                   {"note", "note", false},
                   {"scenes", "scenes", false}};
  // One row for each different statement: a method may expect different things of different scenes.
  std::vector<std::pair<const CellRecord*, std::vector<std::string>>> statements;
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations) {
      const CellRecord* cell = configuration.replicates.empty() ? nullptr : configuration.any_cell();
      if (cell == nullptr) continue;
      auto found = std::find_if(statements.begin(), statements.end(), [&](const auto& entry) {
        const CellRecord& other = *entry.first;
        return other.cell.integrator == cell->cell.integrator && other.bias == cell->bias &&
               other.mse_exponent == cell->mse_exponent && other.note == cell->note;
      });
      if (found == statements.end()) found = statements.insert(statements.end(), {cell, {}});
      if (found->second.empty() || found->second.back() != scene.name) found->second.push_back(scene.name);
    }
  for (const auto& [cell, scenes] : statements) {
    std::string names;
    for (const std::string& scene : scenes) names += (names.empty() ? "" : ", ") + scene;
    TableCell where{scenes.size() == data.scenes.size() && scenes.size() > 1 ? "all" : names, names, std::nullopt};
    table.rows.push_back({TableCell::words(cell->cell.integrator), words_or_none(cell->bias),
                          TableCell::number(cell->mse_exponent, format_short(cell->mse_exponent)), words_or_none(cell->note),
                          where});
  }
  return table;
}

Table failures_table(const ReportData& data) {
  Table table{"failures", "Cells that failed", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false},
                   {"integrator", "integrator", false},
                   {"structure", "structure", false},
                   {"seed", "seed"},
                   {"error", "error", false}};
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations)
      for (const CellRecord* cell : configuration.failures)
        table.rows.push_back({TableCell::words(cell->cell.scene), TableCell::words(cell->cell.integrator),
                              TableCell::words(cell->cell.accel), TableCell::count(cell->cell.seed),
                              words_or_none(cell->error)});
  return table;
}

Table manifest_table(const ReportData& data) {
  Table table{"manifest", "What ran", {}, {}, {}, {}};
  table.columns = {{"manifest", "manifest", false}, {"key", "key", false}, {"value", "value", false}};
  for (const ManifestRecord& m : data.log->manifests) {
    const std::pair<const char*, std::string> entries[] = {{"title", m.title},
                                                           {"version", m.version},
                                                           {"commit", m.commit},
                                                           {"compiler", m.compiler},
                                                           {"flags", m.flags},
                                                           {"cpu", m.cpu},
                                                           {"threads", fmt::format("{}", m.threads)},
                                                           {"experiment hash", m.experiment_hash}};
    const auto add = [&](const char* key, const std::string& value) {
      table.rows.push_back({TableCell::words(m.id), TableCell::words(key), words_or_none(value)});
    };
    for (const auto& [key, value] : entries) add(key, value);
    if (m.isa.empty()) continue;  // a log from before these were noted
    add("processor", fmt::format("{} family {} model {} stepping {}", m.cpu_vendor, m.cpu_family, m.cpu_model, m.cpu_stepping));
    add("instruction set", m.isa);
    add("cores", fmt::format("{}", m.cores));
    add("memory", format_bytes(static_cast<double>(m.memory_bytes)));
    add("date", m.date);
  }
  return table;
}

std::vector<Table> report_tables(const ReportData& data) {
  return {final_table(data), phases_table(data),     counters_table(data),     structures_table(data), references_table(data),
          bias_table(data),  confidence_table(data), expectations_table(data), failures_table(data),   manifest_table(data)};
}

std::string summary_table(const RunLog& log) {
  const ReportData data = arrange(log);
  const Conclusions conclusions = conclude(data);
  std::string out;
  Table table = final_table(data);
  // The names that all rows share stand in the heading; the scene heads each block.
  const std::vector<std::vector<TableCell>> rows = std::move(table.rows);
  table.columns[0].audience = Audience::machines;
  for (const SceneData& scene : data.scenes) {
    out += scene.name;
    if (data.accels.size() == 1) out += fmt::format(" ({})", data.accels.front());
    out += "\n";
    table.rows.clear();
    for (const auto& row : rows)
      if (row[0].raw == scene.name) table.rows.push_back(row);
    if (!table.rows.empty()) out += to_terminal(table, 1);
    for (const SceneVerdicts& verdicts : conclusions.scenes)
      if (verdicts.scene == scene.name)
        for (const Verdict& verdict : verdicts.verdicts)
          out += fmt::format("  {}: {}{}\n", verdict.topic, verdict.lead, verdict.text);
    out += "\n";
  }
  if (const std::vector<FittedRate> rates = fit_rates(data); !rates.empty())
    out += "Rates\n" + to_terminal(rates_table(rates), 1) + "  " + rates_finding(rates) + "\n\n";
  if (const std::vector<FoundRatio> ratios = find_ratios(data); !ratios.empty())
    out += "Ratios\n" + to_terminal(ratios_table(ratios), 0) + "  " + ratios_finding(ratios) + "\n\n";
  for (const std::string& warning : conclusions.warnings) out += "Note: " + warning + "\n";
  if (data.scenes.empty()) out += "The log holds no finished cell.\n";
  return out;
}

}  // namespace etendue
