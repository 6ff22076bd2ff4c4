// The table of ray structures, cut into groups that each fit a terminal.
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace etendue {
namespace {

using Format = std::string (*)(double);

std::string seconds_text(double value) { return format_seconds(value); }
std::string bytes_text(double value) { return format_bytes(value); }
std::string count_text(double value) { return format_count(value); }

TableCell words_or_none(const std::string& text) { return text.empty() ? TableCell{} : TableCell::words(text); }

TableCell figure(double value, Format format = format_figure) {
  return value == 0 ? TableCell{} : TableCell::number(value, format(value));
}

// How far the farther quartile lies from the median, in percent; a single repetition has no spread.
std::string spread_text(const Measured& measured) {
  const double spread = std::max(measured.high - measured.median, measured.median - measured.low) / measured.median;
  if (!(spread > 0)) return {};
  return fmt::format(" ±{:.{}f} %", 100 * spread, spread < 0.0995 ? 1 : 0);
}

// A table that grows column by column, with the cells of all records.
class StructureTable {
 public:
  explicit StructureTable(const RunLog& log) : log_(log), table_{"structures", "Ray structures", {}, {}, {}, {}} {
    table_.rows.resize(log.structures.size());
  }

  // The columns that follow belong to a group of this title, or, where there is nothing to show in it, to programs alone.
  void begin_group(const std::string& title, bool shown = true) {
    if (shown) table_.group_titles.push_back(title);
    group_ = shown ? table_.group_titles.size() : 0;
    audience_ = shown ? Audience::everyone : Audience::machines;
  }

  // cell(record)
  template <class Cell>
  void column(const std::string& key, const std::string& title, const Cell& cell, bool right = true) {
    table_.columns.push_back({key, title, right, audience_, group_});
    for (std::size_t i = 0; i < table_.rows.size(); ++i) table_.rows[i].push_back(cell(log_.structures[i]));
  }

  // A reader's "median ±spread", a program's three columns. get(record) is a Measured.
  template <class Get>
  void measured(const std::string& key, const std::string& title, Format format, const Get& get) {
    const Audience shown = audience_;
    audience_ = shown == Audience::everyone ? Audience::people : Audience::machines;
    if (shown == Audience::everyone)
      column("", title, [&](const StructureRecord& r) {
        TableCell cell = figure(get(r).median, format);
        if (get(r).median != 0) cell.text += spread_text(get(r));
        return cell;
      });
    audience_ = Audience::machines;
    column(key, "", [&](const StructureRecord& r) { return figure(get(r).median, format); });
    column(key + "_low", "", [&](const StructureRecord& r) { return figure(get(r).low, format); });
    column(key + "_high", "", [&](const StructureRecord& r) { return figure(get(r).high, format); });
    audience_ = shown;
  }

  // A group of figures by kind of ray.
  void by_kind(const std::string& title, const std::string& suffix, ByRayKind<Measured> StructureRecord::*figures) {
    const auto& records = log_.structures;
    begin_group(title, std::any_of(records.begin(), records.end(), [&](const StructureRecord& r) {
                  return std::any_of((r.*figures).begin(), (r.*figures).end(), [](const Measured& m) { return m.median > 0; });
                }));
    for (const RayKind kind : ray_kinds)
      measured(ray_kind_name(kind) + suffix, ray_kind_name(kind), format_figure,
               [&](const StructureRecord& r) { return (r.*figures)[index_of(kind)]; });
  }

  void note(const std::string& text) { table_.notes.push_back(text); }
  Table take() { return std::move(table_); }

 private:
  const RunLog& log_;
  Table table_;
  std::size_t group_ = 0;
  Audience audience_ = Audience::everyone;
};

std::string threads_title(const RunLog& log) {
  std::set<int> threads;
  for (const StructureRecord& r : log.structures) threads.insert(r.threads);
  return threads.size() == 1 ? fmt::format("on {} threads", *threads.begin()) : "on all threads";
}

void add_notes(StructureTable& table, const RunLog& log) {
  if (log.structures.empty()) return;
  table.note(
      "Rays on one thread, recorded from a render, the same for every structure: medians of interleaved repetitions, ± the "
      "farther "
      "quartile. Over Embree: ray by ray, repetition by repetition; its streams are told that rays are coherent wherever that "
      "makes them faster.");
  table.note("SAH cost: node visit 1, primitive test 1.");
  const bool sampled = std::any_of(log.structures.begin(), log.structures.end(), [](const StructureRecord& r) {
    return r.epo_triangles > 0 && r.epo_triangles < r.triangles;
  });
  const bool any =
      std::any_of(log.structures.begin(), log.structures.end(), [](const StructureRecord& r) { return r.epo_triangles > 0; });
  if (any)
    table.note(
        std::string("EPO cost [Aila2013]: of the builder's binary tree with leaves of 4, whatever the layout; by clipping "
                    "triangles to boxes") +
        (sampled ? ", on large scenes a sample of 20,000 triangles drawn by area." : ", all of them."));
  table.note(
      "Wrong: answers that double precision refutes, of all rays checked. Embree's default mode and CGAL answer for "
      "themselves.");
}

}  // namespace

Table structures_table(const ReportData& data) {
  const RunLog& log = *data.log;
  StructureTable table(log);
  table.column(
      "scene", "scene", [](const StructureRecord& r) { return words_or_none(r.scene); }, false);
  table.column(
      "structure", "structure", [](const StructureRecord& r) { return words_or_none(r.structure); }, false);
  table.column(
      "layout", "layout", [](const StructureRecord& r) { return words_or_none(r.layout); }, false);

  table.begin_group("Build and memory");
  table.column("triangles", "triangles",
               [](const StructureRecord& r) { return figure(static_cast<double>(r.triangles), count_text); });
  table.measured("build_s", "on 1 thread", seconds_text, [](const StructureRecord& r) { return r.build_s; });
  if (std::any_of(log.structures.begin(), log.structures.end(), [](const StructureRecord& r) { return r.threads > 1; }))
    table.measured("parallel_build_s", threads_title(log), seconds_text,
                   [](const StructureRecord& r) { return r.parallel_build_s; });
  table.column("bytes", "memory", [](const StructureRecord& r) { return figure(static_cast<double>(r.bytes), bytes_text); });
  table.column("bytes_per_triangle", "bytes/triangle", [](const StructureRecord& r) {
    return figure(r.triangles > 0 ? static_cast<double>(r.bytes) / static_cast<double>(r.triangles) : 0);
  });

  table.begin_group("Tree and work");
  table.column("nodes", "nodes", [](const StructureRecord& r) { return figure(static_cast<double>(r.nodes), count_text); });
  table.column("depth", "depth", [](const StructureRecord& r) { return TableCell::count(r.depth); });
  table.column("sah_cost", "SAH", [](const StructureRecord& r) { return figure(r.sah_cost); });
  table.column("epo_cost", "EPO",
               [](const StructureRecord& r) { return r.epo_triangles > 0 ? TableCell::number(r.epo_cost) : TableCell{}; });
  table.column("nodes_per_ray", "nodes/ray", [](const StructureRecord& r) { return figure(r.nodes_per_ray); });
  table.column("primitives_per_ray", "primitives/ray", [](const StructureRecord& r) { return figure(r.primitives_per_ray); });
  table.column("checked", "checked",
               [](const StructureRecord& r) { return figure(static_cast<double>(r.checked), count_text); });
  table.column("disagreements", "wrong", [](const StructureRecord& r) { return TableCell::count(r.disagreements); });

  table.by_kind("Mrays/s, ray by ray", "_mrays_per_s", &StructureRecord::mrays_per_s);
  table.by_kind("Mrays/s, in batches", "_batched_mrays_per_s", &StructureRecord::batched_mrays_per_s);
  table.by_kind("Speed over Embree's, default mode", "_to_embree", &StructureRecord::to_embree);
  table.by_kind("Speed over Embree's, robust mode", "_to_robust_embree", &StructureRecord::to_robust_embree);
  table.by_kind("Batches over Embree's streams", "_batched_to_embree", &StructureRecord::batched_to_embree);
  table.begin_group("What stands in for another", std::any_of(log.structures.begin(), log.structures.end(),
                                                              [](const StructureRecord& r) { return !r.fallback.empty(); }));
  table.column(
      "fallback", "fallback", [](const StructureRecord& r) { return words_or_none(r.fallback); }, false);
  table.begin_group("What was left out", std::any_of(log.structures.begin(), log.structures.end(),
                                                     [](const StructureRecord& r) { return !r.note.empty(); }));
  table.column(
      "note", "note", [](const StructureRecord& r) { return words_or_none(r.note); }, false);
  add_notes(table, log);
  return table.take();
}

}  // namespace etendue
