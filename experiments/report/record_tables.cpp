// The tables that list records as they are, and the summary at the end of a run.
#include "experiments/report/declared.h"
#include "experiments/report/rates.h"
#include "experiments/report/ratios.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace etendue {

Table references_table(const ReportData& data) {
  TableOf<ReferenceRecord> table("references", "References", data.log->references);
  table.column("scene", "scene", &ReferenceRecord::scene);
  table.column("source", "source", &ReferenceRecord::source);
  table.column("size", "pixels", [](const ReferenceRecord& r) {
    return TableCell::ordered(fmt::format("{}×{}", r.width, r.height), static_cast<double>(r.width) * r.height);
  });
  table.column("mse_floor", "own variance",
               [](const ReferenceRecord& r) { return knows_variance(r) ? TableCell(r.mse_floor) : TableCell(); });
  table.column("floor_share", "of least mse", [&](const ReferenceRecord& r) {
    double share = 0;
    for (const SceneData& scene : data.scenes)
      if (scene.name == r.scene) share = floor_share(scene);
    if (share == 0) return TableCell();
    return TableCell(share, format_figure(100 * share) + (share > floor_share_limit ? " % (above 1 %)" : " %"));
  });
  table.column("checks", "checks", &ReferenceRecord::checks);
  table.column("file", "file", [](const ReferenceRecord& r) { return std::filesystem::path(r.file).filename().string(); });
  table.data("scene_hash", &ReferenceRecord::scene_hash);
  return table.take();
}

namespace {

struct ElsewhereRow {
  const ElsewhereFigure* figure;
  const SceneData* scene;
  const Configuration* best = nullptr;  // of those here, at the same time
  double error = 0;                     // its
};

std::vector<ElsewhereRow> elsewhere_rows(const ReportData& data) {
  std::vector<ElsewhereRow> rows;
  for (const SceneData& scene : data.scenes)
    for (const ElsewhereFigure& figure : data.log->stated.elsewhere) {
      if (!figure.of_scene(scene.name)) continue;
      ElsewhereRow& row = rows.emplace_back(ElsewhereRow{&figure, &scene});
      for (const Configuration* configuration : scene.finished())
        if (const auto error = estimate_at(*configuration, figure.metric, figure.time_s, data.is_signed(figure.metric));
            error && (row.best == nullptr || std::abs(error->centre) < std::abs(row.error))) {
          row.best = configuration;
          row.error = error->centre;
        }
    }
  return rows;
}

}  // namespace

Table elsewhere_table(const ReportData& data) {
  TableOf<ElsewhereRow> table("elsewhere", "What others measured", elsewhere_rows(data));
  const auto text = [](std::string ElsewhereFigure::*field) {
    return [field](const ElsewhereRow& row) { return row.figure->*field; };
  };
  table.column("scene", "scene", [](const ElsewhereRow& row) { return row.scene->name; });
  table.column("program", "program", text(&ElsewhereFigure::program));
  table.column("method", "method", text(&ElsewhereFigure::method));
  table.column("time_s", "time", [](const ElsewhereRow& row) { return TableCell(row.figure->time_s, format_seconds); });
  table.column("metric", "metric", text(&ElsewhereFigure::metric));
  table.column("error", "error", [](const ElsewhereRow& row) { return row.figure->error; });
  table.column("best", "best here then", [&](const ElsewhereRow& row) { return row.best ? label(data, *row.best) : ""; });
  table.column("best_error", "its error",
               [](const ElsewhereRow& row) { return row.best ? TableCell(row.error) : TableCell(); });
  table.column("machine", "machine", text(&ElsewhereFigure::machine));
  table.column("date", "date", text(&ElsewhereFigure::date));
  table.column("source", "source", text(&ElsewhereFigure::source));
  table.note("Figures of other programs are data: they were measured on the machine that stands beside them, not on this one.");
  return table.take();
}

namespace {

// Holds what a method declares, and of which scenes: it may expect different things of different ones.
struct Statement {
  const CellRecord* cell;
  std::vector<std::string> scenes;

  bool is_of(const CellRecord& other) const {
    return other.cell.integrator == cell->cell.integrator && other.bias == cell->bias &&
           other.mse_exponent == cell->mse_exponent && other.note == cell->note;
  }
};

std::vector<Statement> statements_of(const ReportData& data) {
  std::vector<Statement> statements;
  for (const Configuration* configuration : data.finished()) {
    const CellRecord& cell = *configuration->any_cell();
    Statement& statement = find_or_add(statements, [&](const Statement& s) { return s.is_of(cell); }, {&cell, {}});
    index_in(statement.scenes, configuration->scene);
  }
  return statements;
}

}  // namespace

Table expectations_table(const ReportData& data) {
  TableOf<Statement> table("expectations", "What the methods declare", statements_of(data));
  table.column("integrator", "integrator", [](const Statement& s) { return s.cell->cell.integrator; });
  table.column("declared_bias", "bias", [](const Statement& s) { return s.cell->bias; });
  table.column("declared_mse_exponent", "exponent of MSE",
               [](const Statement& s) { return TableCell(s.cell->mse_exponent, format_short); });
  table.column("note", "note", [](const Statement& s) { return s.cell->note; });
  const auto names = [](const Statement& s) { return joined(s.scenes, ", "); };
  const auto shown = [&](const Statement& s) {
    return s.scenes.size() == data.scenes.size() && s.scenes.size() > 1 ? "all" : names(s);
  };
  table.column("", "scenes", shown, Audience::people);
  table.data("scenes", names);
  return table.take();
}

Table failures_table(const ReportData& data) {
  std::vector<const CellRecord*> failures;
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations)
      failures.insert(failures.end(), configuration.failures.begin(), configuration.failures.end());
  TableOf<const CellRecord*> table("failures", "Cells that failed", failures);
  table.column("scene", "scene", [](const CellRecord* c) { return c->cell.scene; });
  table.column("integrator", "integrator", [](const CellRecord* c) { return c->cell.integrator; });
  table.column("structure", "structure", [](const CellRecord* c) { return c->cell.accel; });
  table.column("seed", "seed", [](const CellRecord* c) { return c->cell.seed; });
  table.column("error", "error", &CellRecord::error);
  return table.take();
}

Table manifest_table(const ReportData& data) {
  Table table{"manifest", "What ran"};
  table.columns = {{"manifest", "manifest", false}, {"key", "key", false}, {"value", "value", false}};
  for (const ManifestRecord& m : data.log->manifests) {
    const auto add = [&](const char* key, const std::string& value) { table.rows.push_back({m.id, key, value}); };
    add("title", m.title);
    add("version", m.version);
    add("commit", m.commit);
    add("compiler", m.compiler);
    add("flags", m.flags);
    add("cpu", m.cpu);
    add("threads", fmt::format("{}", m.threads));
    add("experiment hash", m.experiment_hash);
    add("processor", fmt::format("{} family {} model {} stepping {}", m.cpu_vendor, m.cpu_family, m.cpu_model, m.cpu_stepping));
    add("instruction set", m.isa);
    add("cores", fmt::format("{}", m.cores));
    add("memory", format_bytes(static_cast<double>(m.memory_bytes)));
    add("date", m.date);
  }
  return table;
}

std::vector<Table> report_tables(const ReportData& data) {
  return {final_table(data),      phases_table(data),       counters_table(data), structures_table(data), elsewhere_table(data),
          references_table(data), expectations_table(data), failures_table(data), manifest_table(data)};
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
    if (data.accels.size() == 1) out += fmt::format(" ({})", data.shown_accels.front());
    out += "\n";
    table.rows.clear();
    for (const auto& row : rows)
      if (row[0].raw == scene.name) table.rows.push_back(row);
    if (!table.rows.empty()) out += to_terminal(table, 1);
    for (const SceneFindings& found : conclusions.scenes)
      if (found.scene == scene.name)
        for (const Finding& finding : found.findings)
          out += fmt::format("  {}: {}{}\n", finding.topic, finding.lead, finding.text);
    out += "\n";
  }
  Predictions stated = exponent_predictions(fit_rates(data));
  stated.add(ratio_predictions(data));
  stated.add(image_bias_predictions(data));
  if (!stated.rows.empty())
    out += "Predictions\n" + to_terminal(predictions_table(stated), 1) + "  " + predictions_finding(stated) + "\n\n";
  if (!data.left_out_of_names.empty()) out += fmt::format("Left out of names: {}.\n", fmt::join(data.left_out_of_names, "; "));
  for (const std::string& warning : conclusions.warnings) out += "Note: " + warning + "\n";
  if (data.scenes.empty()) out += "The log holds no finished cell.\n";
  return out;
}

}  // namespace etendue
