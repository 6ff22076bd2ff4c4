#include "experiments/kinds/throughput/throughput_record.h"
#include "experiments/report/report_data.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/isa.h"
#include "framework/core/units.h"

#include <fmt/format.h>
#include <algorithm>
#include <optional>

namespace etendue {

namespace {

// A line of the table: a cell with one instruction set.
struct ThroughputRow {
  const ThroughputRecord* record;
  const Throughput* figures;

  std::string isa() const { return std::string(isa_name(isa_of_option(figures->isa))); }
  std::string series() const { return record->cell.integrator + ", " + isa(); }
};

std::vector<ThroughputRow> rows_of(const RunLog& log) {
  std::vector<ThroughputRow> rows;
  for (const ThroughputRecord* record : done_records_of<ThroughputRecord>(log))
    for (const Throughput& figures : record->sets) rows.push_back({record, &figures});
  return rows;
}

// They stand in the order in which they ran, the newest last.
std::vector<std::string> commits_of(const RunLog& log) {
  std::vector<std::string> commits;
  for (const ThroughputRecord* record : records_of<ThroughputRecord>(log)) index_in(commits, record->commit());
  return commits;
}

// The record of the cell by the first commit that ran it, likewise; null: this one was the first.
const Throughput* first_of(const std::vector<ThroughputRow>& rows, const ThroughputRow& row) {
  for (const ThroughputRow& other : rows)
    if (other.record->cell.scene == row.record->cell.scene && other.series() == row.series())
      return other.record == row.record ? nullptr : other.figures;
  return nullptr;
}

std::string shares_text(const Throughput& figures) {
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [phase, share] : figures.shares)
    if (share >= 0.005) order.emplace_back(share, phase);
  std::sort(order.rbegin(), order.rend());
  return joined(order, ", ", [](const auto& of) { return fmt::format("{} {:.0f} %", of.second, 100 * of.first); });
}

std::vector<ThroughputRow> newest_of(const RunLog& log, const std::vector<ThroughputRow>& all) {
  std::vector<ThroughputRow> newest;
  for (const ThroughputRow& row : all)
    if (row.record->commit() == commits_of(log).back()) newest.push_back(row);
  return newest;
}

// The fastest method on the first scene, and what the last instruction set gains over the first in all cells.
std::string throughput_answer(const RunLog& log) {
  const std::vector<ThroughputRow> all = rows_of(log), rows = newest_of(log, all);
  if (rows.empty()) return {};
  const auto speed = [](const ThroughputRow& row) { return row.figures->samples_per_s.median; };
  const ThroughputRow* fastest = &rows.front();
  std::vector<double> gains;
  for (const ThroughputRow& row : rows) {
    if (row.record->cell.scene == fastest->record->cell.scene && speed(row) > speed(*fastest)) fastest = &row;
    const std::vector<Throughput>& sets = row.record->sets;
    if (row.figures == &sets.back() && sets.size() > 1)
      gains.push_back(sets.back().samples_per_s.median / sets.front().samples_per_s.median);
  }
  const double most_per_s = speed(*fastest);
  std::string text =
      fmt::format("{} traces the most camera samples: {} a second on {} with {}", fastest->record->cell.integrator,
                  most_per_s < 1e6 ? format_count(most_per_s) : fmt::format("{:.1f} M", 1e-6 * most_per_s),
                  slug(fastest->record->cell.scene), fastest->isa());
  if (gains.empty()) return text;
  const auto [least, most] = std::ranges::minmax(gains);
  const std::vector<Throughput>& sets = fastest->record->sets;
  return fmt::format("{}; over all methods and scenes {} does {:.2f} to {:.2f} times what {} does", text,
                     isa_name(isa_of_option(sets.back().isa)), least, most, isa_name(isa_of_option(sets.front().isa)));
}

Table newest_table(const RunLog& log) {
  const std::vector<ThroughputRow> all = rows_of(log), newest = newest_of(log, all);
  TableOf<ThroughputRow> table("throughput", "Throughput", newest);
  table.column("scene", "scene", [](const ThroughputRow& r) { return r.record->cell.scene; });
  table.column("integrator", "method", [](const ThroughputRow& r) { return r.record->cell.integrator; });
  table.column("isa", "with", &ThroughputRow::isa);
  table.data("commit", [](const ThroughputRow& r) { return r.record->commit(); });
  table.group("Rates");
  const auto column = [&](const std::string& key, const char* title, Measured Throughput::*figure) {
    table.column(key, title,
                 [=](const ThroughputRow& r) { return TableCell::positive((r.figures->*figure).median, format_count); });
    const auto end = [&](const char* suffix, double Measured::*part) {
      table.data(key + suffix, [=](const ThroughputRow& r) { return TableCell((r.figures->*figure).*part); });
    };
    end("_low", &Measured::low);
    end("_high", &Measured::high);
  };
  column("samples_per_s", "samples/s", &Throughput::samples_per_s);
  column("rays_per_s", "rays/s", &Throughput::rays_per_s);
  column("photons_per_s", "photons/s", &Throughput::photons_per_s);
  column("records_per_s", "records/s", &Throughput::records_per_s);
  table.column("over_first", "over first", [&](const ThroughputRow& r) {
    const Throughput* first = first_of(all, r);
    if (first == nullptr) return TableCell();
    const double factor = r.figures->samples_per_s.median / first->samples_per_s.median;
    return TableCell(factor, fmt::format("{:.2f}", factor));
  });
  table.group("Share of time by phase");
  table.column("phases", "phases", [](const ThroughputRow& r) { return shares_text(*r.figures); });
  table.note(
      "Medians of repetitions by turns, of the newest commit. Samples: of the camera, in the time of the whole render but for "
      "reading the scene; rays: of all kinds, likewise; photons: emitted, in the time of emission; records: of caches, in that "
      "of the initial pass. Over first: camera samples a second over those of the first commit in the log.");
  return table.take(failed_cells<ThroughputRecord>(log));
}

std::vector<std::string> names_of(const std::vector<ThroughputRow>& rows, const std::string& scene,
                                  std::string (*name)(const ThroughputRow&)) {
  std::vector<std::string> names;
  for (const ThroughputRow& row : rows)
    if (row.record->cell.scene == scene) index_in(names, name(row));
  return names;
}

// A series for each instruction set; `place(row)` is where its point lies, if it has one. All charts tell the sets alike.
template <class Place>
std::vector<ChartSeries> series_by_isa(const std::vector<ThroughputRow>& rows, const std::string& scene, const Place& place) {
  std::vector<ChartSeries> all;
  for (const std::string& isa : names_of(rows, scene, [](const ThroughputRow& r) { return r.isa(); })) {
    ChartSeries series;
    series.key = series.label = isa;
    series.style(all.size());
    for (const ThroughputRow& row : rows)
      if (row.record->cell.scene == scene && row.isa() == isa)
        if (const std::optional<ChartPoint> point = place(row)) series.points.push_back(*point);
    all.push_back(std::move(series));
  }
  return all;
}

// Camera samples a second of each method with the newest commit that ran it.
Figure methods_figure(const std::vector<ThroughputRow>& rows, const std::string& scene) {
  Chart chart;
  chart.x = {"camera samples a second", Scale::log, std::nullopt};
  chart.rows = names_of(rows, scene, [](const ThroughputRow& r) { return r.record->cell.integrator; });
  chart.series = series_by_isa(rows, scene, [&](const ThroughputRow& row) -> std::optional<ChartPoint> {
    for (const ThroughputRow& later : rows)
      if (&later > &row && later.record->cell.scene == scene && later.series() == row.series()) return std::nullopt;
    const auto at = std::find(chart.rows.begin(), chart.rows.end(), row.record->cell.integrator) - chart.rows.begin();
    return ChartPoint(row.figures->samples_per_s.median, static_cast<double>(at));
  });
  for (ChartSeries& series : chart.series) series.draw = ChartSeries::Draw::dots;
  return {"throughput-" + slug(scene), scene, "camera samples a second", {std::move(chart)}, {}};
}

// Shows the same over commits, with a panel for each method.
Figure history_figure(const std::vector<ThroughputRow>& rows, const std::string& scene,
                      const std::vector<std::string>& commits) {
  Figure figure{"throughput-by-commit-" + slug(scene), scene, "camera samples a second, by commit", {}, {}};
  for (const std::string& method : names_of(rows, scene, [](const ThroughputRow& r) { return r.record->cell.integrator; })) {
    Chart chart{.title = method};
    chart.x = {"commit", Scale::linear, Interval{0, static_cast<double>(commits.size()) + 1}};  // no ticks at halves
    chart.y = {"samples/s", Scale::log, std::nullopt};
    chart.series = series_by_isa(rows, scene, [&](const ThroughputRow& row) -> std::optional<ChartPoint> {
      if (row.record->cell.integrator != method) return std::nullopt;
      const auto at = std::find(commits.begin(), commits.end(), row.record->commit()) - commits.begin();
      const Measured& m = row.figures->samples_per_s;
      return ChartPoint(static_cast<double>(at + 1), m.median, m.low, m.high);
    });
    figure.panels.push_back(std::move(chart));
  }
  std::string names;
  for (std::size_t i = 0; i < commits.size(); ++i) names += fmt::format("{}{} {}", i ? ", " : "", i + 1, commits[i]);
  figure.notes.push_back("Commits in the order of their runs: " + names + ". Bands are quartiles.");
  return figure;
}

}  // namespace

KindReport throughput_report(const RunLog& log) {
  if (records_of<ThroughputRecord>(log).empty()) return {};
  const std::vector<std::string> commits = commits_of(log);
  KindReport report{.fact = counted(commits.size(), "commit"),
                    .tables = {newest_table(log)},
                    .answer = throughput_answer(log),
                    .id = "throughput",
                    .heading = "Throughput"};
  std::vector<std::string> scenes;
  for (const ThroughputRecord* record : records_of<ThroughputRecord>(log)) index_in(scenes, record->cell.scene);
  const std::vector<ThroughputRow> rows = rows_of(log);
  for (const std::string& scene : scenes) {
    report.figures.push_back({scene, {methods_figure(rows, scene)}});
    if (commits.size() > 1) report.figures.back().figures.push_back(history_figure(rows, scene, commits));
  }
  return report;
}

std::string throughput_summary(const RunLog& log) {
  if (records_of<ThroughputRecord>(log).empty()) return {};
  const Table table = newest_table(log);
  return to_terminal(table, 1) + "\n" + to_terminal(table, 2);
}

}  // namespace etendue
