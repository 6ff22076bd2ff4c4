// Small logs and pictures for the tests of the report.
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/charts/charts.h"
#include "experiments/report/table_format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace etendue::report_test {

// A method whose mean squared error is variance * N^exponent, its seeds a factor apart, its iterations equally long.
struct LoggedMethod {
  std::string integrator = "path", accel = "sah";
  double seconds_per_iteration = 0.1, variance = 1, exponent = -1;
  int checkpoints = 8;
  std::string bias = "unbiased";
};

inline std::size_t column(const Table& table, const std::string& key) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(), [&](const auto& c) { return c.key == key; });
  EXPECT_NE(found, table.columns.end()) << key;
  return static_cast<std::size_t>(found - table.columns.begin());
}

inline void add_cell(RunLog& log, const std::string& scene, const LoggedMethod& method, std::uint64_t seed) {
  const CellName name{scene, method.accel, method.integrator, seed};
  const double factor = std::exp(0.1 * std::sin(7.0 * static_cast<double>(seed)));
  for (int i = 0; i < method.checkpoints; ++i) {
    CheckpointRecord record;
    record.cell = name;
    record.manifest = "m";
    record.iterations = 1u << i;
    const auto n = static_cast<double>(record.iterations);
    record.time_s = method.seconds_per_iteration * n;
    record.cpu_s = 2 * record.time_s;
    record.phases_s = {{"build", 0.25 * record.time_s}, {"trace", 0.75 * record.time_s}, {"other", 0}};
    const double error = factor * method.variance * std::pow(n, method.exponent);
    record.metrics = {
        {"relmse", error}, {"mse", 0.5 * error}, {"bias", 0.01 * std::sin(static_cast<double>(seed)) / std::sqrt(n)}};
    record.counters = {{"rays", 1000 * record.iterations}, {"shadow_rays", 500 * record.iterations}, {"records", 0}};
    record.peak_memory_bytes = 1 << 20;
    log.checkpoints.push_back(record);
  }
  CellRecord cell;
  cell.cell = name;
  cell.status = "done";
  cell.bias = method.bias;
  cell.mse_exponent = method.exponent;
  cell.note = "a note";
  log.cells.push_back(cell);
}

inline void add_cells(RunLog& log, const std::string& scene, const LoggedMethod& method, int seeds) {
  for (int seed = 1; seed <= seeds; ++seed) add_cell(log, scene, method, static_cast<std::uint64_t>(seed));
}

inline void add_failure(RunLog& log, const CellName& name, const std::string& error) {
  CellRecord cell;
  cell.cell = name;
  cell.status = "failed";
  cell.error = error;
  log.cells.push_back(cell);
}

inline ReferenceRecord reference(const std::string& scene, double floor = 0) {
  ReferenceRecord record;
  record.scene = scene;
  record.scene_hash = "hash";
  record.source = floor > 0 ? "two estimators" : "closed form";
  record.mse_floor = floor;
  record.width = 8;
  record.height = 6;
  return record;
}

inline ManifestRecord manifest(const std::string& title = "A question") {
  ManifestRecord record;
  record.id = "m";
  record.version = "0.1.0";
  record.commit = "abc";
  record.cpu = "a CPU";
  record.title = title;
  record.threads = 2;
  return record;
}

// Two methods that cross, three seeds each.
inline RunLog small_log() {
  RunLog log;
  log.manifests.push_back(manifest());
  log.references.push_back(reference("builtin:room"));
  add_cells(log, "builtin:room", {"path", "sah", 0.1, 1, -1}, 3);
  add_cells(log, "builtin:room", {"sppm", "sah", 0.1, 0.1, -2.0 / 3, 8, "consistent"}, 3);
  return log;
}

inline StructureRecord structure(const std::string& scene, const std::string& name, const std::string& layout, double mrays,
                                 double build_s) {
  StructureRecord record;
  record.scene = scene;
  record.structure = name;
  record.layout = layout;
  record.triangles = 1000;
  record.bytes = 64000;
  record.nodes = 999;
  record.depth = 12;
  record.build_s = {build_s, build_s, build_s};
  const auto speed = [&](RayKind kind, double value) { record.speed(kind) = {value, 0.99 * value, 1.01 * value}; };
  speed(RayKind::primary, 2 * mrays);
  speed(RayKind::diffuse, mrays);
  speed(RayKind::shadow, 1.5 * mrays);
  return record;
}

// Whether every tag of an XML document is closed in order and no bare < or & is left: enough for what the report writes itself.
inline ::testing::AssertionResult well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < xml.size(); ++i) {
    if (xml[i] == '&') {
      const std::size_t end = xml.find(';', i);
      if (end == std::string::npos || end - i > 8) return ::testing::AssertionFailure() << "bare & at " << xml.substr(i, 30);
    }
    if (xml[i] != '<') continue;
    const std::size_t end = xml.find('>', i);
    if (end == std::string::npos) return ::testing::AssertionFailure() << "unclosed tag at " << xml.substr(i, 30);
    const std::string tag = xml.substr(i + 1, end - i - 1);
    if (tag.find('<') != std::string::npos) return ::testing::AssertionFailure() << "bare < at " << xml.substr(i, 30);
    const std::string name = tag.substr(tag[0] == '/' ? 1 : 0, tag.find_first_of(" \n/>", 1) - (tag[0] == '/' ? 1 : 0));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1))
        return ::testing::AssertionFailure() << "</" << name << "> closes nothing";
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
    i = end;
  }
  if (!open.empty()) return ::testing::AssertionFailure() << "<" << open.back() << "> is left open";
  return ::testing::AssertionSuccess();
}

// Whether each column of figures that readers see has cells by which it is sorted, unless nothing stands in it.
inline ::testing::AssertionResult columns_of_figures_sort(const Table& table) {
  for (const std::size_t c : visible_columns(table)) {
    const auto is_filled = [&](const auto& row) { return row[c].text != TableCell().text; };
    const auto is_ordered = [&](const auto& row) { return row[c].order.has_value(); };
    if (table.columns[c].right && std::ranges::any_of(table.rows, is_filled) && std::ranges::none_of(table.rows, is_ordered))
      return ::testing::AssertionFailure() << table.name << ": " << table.columns[c].title;
  }
  return ::testing::AssertionSuccess();
}

// Whether series of one key look alike in all panels: a legend names those of the first.
inline ::testing::AssertionResult looks_alike_in_all_panels(const Figure& figure) {
  std::map<std::string, const ChartSeries*> known;
  for (const Chart& chart : figure.panels)
    for (const ChartSeries& series : chart.series) {
      if (!series.is_in_legend()) continue;
      const ChartSeries& first = *known.try_emplace(series.key, &series).first->second;
      if (std::tie(first.colour, first.dash, first.marker) != std::tie(series.colour, series.dash, series.marker))
        return ::testing::AssertionFailure() << figure.name << ": " << series.key << " in " << chart.title;
    }
  return ::testing::AssertionSuccess();
}

inline std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

inline std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace etendue::report_test
