// The table of ray structures, cut into groups that each fit a terminal.
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "experiments/report/tables.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace etendue {
namespace {

using Cells = std::vector<TableCell>;
using Format = std::string (*)(double);

// How far the farther quartile lies from the median, in percent; a single repetition has no spread.
std::string spread_text(const Measured& measured) {
  const double spread = std::max(measured.high - measured.median, measured.median - measured.low) / measured.median;
  if (!(spread > 0)) return {};
  return fmt::format(" ±{:.{}f} %", 100 * spread, spread < 0.0995 ? 1 : 0);
}

class StructureTable : public TableOf<StructureRecord> {
 public:
  explicit StructureTable(const RunLog& log)
      : TableOf("structures", "Ray structures", log.structures), records_(log.structures) {}

  bool any(const auto& test) const { return std::ranges::any_of(records_, test); }

  // Adds a number of the record, which has no cell where it is 0.
  void number(const char* key, const char* title, auto StructureRecord::*member, Format format = format_figure) {
    column(key, title, [=](const StructureRecord& r) { return TableCell::positive(static_cast<double>(r.*member), format); });
  }

  // A reader's "median ±spread", a program's three columns. get(record) is a Measured.
  void measured(const std::string& key, const std::string& title, Format format, const auto& get) {
    parts(title, {key, key + "_low", key + "_high"}, [&](const StructureRecord& r) -> Cells {
      const Measured& m = std::invoke(get, r);
      const auto cell = [&](double value) { return TableCell::positive(value, format); };
      TableCell text = cell(m.median);
      if (m.median != 0) text.text += spread_text(m);
      return {text, cell(m.median), cell(m.low), cell(m.high)};
    });
  }

  // Adds a group of figures by kind of ray.
  void by_kind(const char* title, const std::string& suffix, ByRayKind<Measured> StructureRecord::*figures) {
    group(title, any([&](const StructureRecord& r) {
            return std::ranges::any_of(r.*figures, [](const Measured& m) { return m.median > 0; });
          }));
    for (const RayKind kind : ray_kinds)
      measured(ray_kind_name(kind) + suffix, ray_kind_name(kind), format_figure,
               [&](const StructureRecord& r) { return (r.*figures)[index_of(kind)]; });
  }

 private:
  const std::vector<StructureRecord>& records_;
};

std::string threads_title(const RunLog& log) {
  std::set<int> threads;
  for (const StructureRecord& r : log.structures) threads.insert(r.threads);
  return threads.size() == 1 ? fmt::format("on {} threads", *threads.begin()) : "on all threads";
}

void add_notes(StructureTable& table) {
  table.note(
      "Rays on one thread, recorded from a render, the same for every structure: medians of interleaved repetitions, ± the "
      "farther quartile. Over Embree: ray by ray, repetition by repetition; its streams are told that rays are coherent "
      "wherever that makes them faster.");
  table.note("SAH cost: node visit 1, primitive test 1.");
  const bool sampled = table.any([](const StructureRecord& r) { return r.epo_triangles > 0 && r.epo_triangles < r.triangles; });
  if (table.any([](const StructureRecord& r) { return r.epo_triangles > 0; }))
    table.note(
        std::string("EPO cost [Aila2013]: of the builder's binary tree with leaves of 4, whatever the layout; by clipping "
                    "triangles to boxes") +
        (sampled ? ", on large scenes a sample of 20,000 triangles drawn by area." : ", all of them."));
  table.note(
      "Wrong: answers that double precision refutes, of all that were checked. Embree's default mode and CGAL answer for "
      "themselves.");
}

}  // namespace

Table structures_table(const ReportData& data) {
  StructureTable table(*data.log);
  table.column("scene", "scene", &StructureRecord::scene);
  table.column("structure", "structure", &StructureRecord::structure);
  table.column("layout", "layout", &StructureRecord::layout);

  table.group("Build and memory");
  table.number("triangles", "triangles", &StructureRecord::triangles, format_count);
  table.measured("build_s", "on 1 thread", format_seconds, &StructureRecord::build_s);
  if (table.any([](const StructureRecord& r) { return r.threads > 1; }))
    table.measured("parallel_build_s", threads_title(*data.log), format_seconds, &StructureRecord::parallel_build_s);
  table.number("bytes", "memory", &StructureRecord::bytes, format_bytes);
  table.column("bytes_per_triangle", "bytes/triangle", [](const StructureRecord& r) {
    const double each = r.triangles > 0 ? static_cast<double>(r.bytes) / static_cast<double>(r.triangles) : 0;
    return TableCell::positive(each, format_figure);
  });

  table.group("Tree and work");
  table.number("nodes", "nodes", &StructureRecord::nodes, format_count);
  table.column("depth", "depth", &StructureRecord::depth);
  table.number("sah_cost", "SAH", &StructureRecord::sah_cost);
  table.column("epo_cost", "EPO",
               [](const StructureRecord& r) { return r.epo_triangles > 0 ? std::optional(r.epo_cost) : std::nullopt; });
  table.number("nodes_per_ray", "nodes/ray", &StructureRecord::nodes_per_ray);
  table.number("primitives_per_ray", "primitives/ray", &StructureRecord::primitives_per_ray);
  table.number("checked", "checked", &StructureRecord::checked, format_count);
  table.column("disagreements", "wrong", &StructureRecord::disagreements);

  table.by_kind("Mrays/s, ray by ray", "_mrays_per_s", &StructureRecord::mrays_per_s);
  table.by_kind("Mrays/s, in batches", "_batched_mrays_per_s", &StructureRecord::batched_mrays_per_s);
  table.by_kind("Speed over Embree's, default mode", "_to_embree", &StructureRecord::to_embree);
  table.by_kind("Speed over Embree's, robust mode", "_to_robust_embree", &StructureRecord::to_robust_embree);
  table.by_kind("Batches over Embree's streams", "_batched_to_embree", &StructureRecord::batched_to_embree);
  table.group("What stands in for another", table.any([](const StructureRecord& r) { return !r.fallback.empty(); }));
  table.column("fallback", "fallback", &StructureRecord::fallback);
  table.group("What was left out", table.any([](const StructureRecord& r) { return !r.note.empty(); }));
  table.column("note", "note", &StructureRecord::note);
  add_notes(table);
  return table.take();
}

}  // namespace etendue
