// The map that a log's cells make: thresholds, in words and judged.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/report_text.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

std::string x_text(double x) { return fmt::format("{:g}", std::strtod(fmt::format("{:.2g}", x).c_str(), nullptr)); }

std::string y_text(double y) { return y < 1e4 ? fmt::format("{:g}", y) : format_count(y); }

std::string with_unit(const std::string& text, const std::string& unit) { return unit.empty() ? text : text + " " + unit; }

double crossed_bound(const StressRecord& r) {
  const auto first = std::ranges::find_if(r.points, [&](const StressPoint& p) { return is_failed(p, r.holds); });
  return first != r.points.end() && mean(first->values) < r.holds.low ? r.holds.low : r.holds.high;
}

Interval StressCell::x_interval() const {
  const auto [low, high] = threshold->interval;
  const bool rises = record->range.to > record->range.from;
  const double first = low > 0 ? record->range.at(low) : rises ? 0 : endless;
  const double last = high < 1 ? record->range.at(high) : rises ? endless : 0;
  return {std::min(first, last), std::max(first, last)};
}

std::string StressCell::threshold_text() const {
  if (!record->inapplicable.empty()) return "–";
  if (!threshold) return "failed to run";
  if (threshold->holding == Holding::to_the_end) return "holds";
  return (threshold->holding == Holding::nowhere ? "fails" : x_text(x())) + (threshold->is_monotone ? "" : "†");
}

std::string StressCell::interval_text() const {
  if (!threshold || threshold->holding != Holding::up_to) return "";
  const Interval of = x_interval();
  if (of.low == 0) return std::isinf(of.high) ? "anywhere" : "below " + x_text(of.high);
  if (std::isinf(of.high)) return "above " + x_text(of.low);
  return x_text(of.low) + "–" + x_text(of.high);
}

TableCell StressCell::interval_cell() const {
  const std::string text = interval_text();
  return TableCell::ordered(text, text.empty() ? std::nullopt : std::optional(x_interval().low));
}

std::string StressCell::verdict_text() const {
  if (!record->inapplicable.empty()) return "does not apply: " + record->inapplicable;
  if (!threshold) return "failed to run: " + record->error;
  if (threshold->holding == Holding::to_the_end) return "holds to the end";
  const char* recovers = threshold->is_monotone ? "" : ", recovers beyond";
  if (threshold->holding == Holding::up_to)
    return fmt::format("fails from {} on{}", with_unit(x_text(x()), record->unit), recovers);
  const StressPoint& first = record->points.front();
  const bool biased = std::abs(first.bias) > std::max(0.01, 3 * first.bias_error) && !record->of_structure;
  return fmt::format("fails everywhere{}{}", biased ? fmt::format(": biased by {:+.1f} %", 100 * first.bias) : "", recovers);
}

std::string StressCell::name() const {
  const StressRecord& r = *record;
  if (r.y) return fmt::format("{}, {} {}", r.column, r.second, with_unit(y_text(*r.y), r.second_unit));
  return r.remedy.empty() ? r.column : r.column + ": " + r.remedy;
}

std::string StressCell::anchor() const { return record->cell.accel + "-" + slug(record->cell.integrator); }

std::optional<double> StressCell::calm_error() const {
  if (!threshold || record->of_structure || record->points.empty()) return std::nullopt;
  const StressPoint& last = record->points.back();
  const double n = static_cast<double>(last.values.size());
  if (n < 2 || std::abs(last.bias) < 0.1 || last.bias_error * std::sqrt(n) > std::abs(last.bias) / 5) return std::nullopt;
  return last.bias;
}

const StressCell* StressRow::of(const std::string& column) const {
  const auto found = std::ranges::find_if(cells, [&](const StressCell& cell) { return cell.record->column == column; });
  return found == cells.end() ? nullptr : &*found;
}

std::size_t StressRow::broken() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      cells, [](const StressCell& cell) { return cell.threshold && cell.threshold->holding != Holding::to_the_end; }));
}

StressMap arrange_stress(const RunLog& log) {
  StressMap map;
  for (const StressRecord* record : records_of<StressRecord>(log)) {
    StressCell cell{record};
    if (record->done() && !record->points.empty()) cell.threshold = threshold_of(record->curve(), record->holds);
    StressRow& row = find_or_add(
        record->y ? map.grids : map.rows, [&](const StressRow& r) { return r.id == record->id; },
        StressRow{record->id, {}, {}});
    if (!record->remedy.empty()) {
      row.remedies.push_back(cell);
      continue;
    }
    row.cells.push_back(cell);
    if (record->y) continue;
    auto& columns = record->of_structure ? map.structure_columns : map.columns;
    find_or_add(
        columns, [&](const std::string& column) { return column == record->column; }, record->column);
  }
  // A filter may leave remedies without what they mend.
  std::erase_if(map.rows, [](const StressRow& row) { return row.cells.empty(); });
  for (auto* rows : {&map.rows, &map.grids}) std::ranges::stable_sort(*rows, {}, &StressRow::id);
  for (StressRow& grid : map.grids)
    std::ranges::stable_sort(grid.cells, {}, [](const StressCell& cell) { return *cell.record->y; });
  return map;
}

std::optional<JudgedPrediction> judge_stress(const StressCell& cell) {
  const StressRecord& r = *cell.record;
  if (!r.is_expected || !cell.threshold) return std::nullopt;
  JudgedPrediction row{.id = r.id,
                       .statement = r.failure,
                       .scene = r.cell.scene,
                       .method = r.column,
                       .remedy = r.remedy,
                       .quantity = "threshold of " + r.parameter,
                       .source = r.source,
                       .expected = Expected{r.expected_low.value_or(-endless), r.expected_high.value_or(endless)}};
  // One that holds to the end has its threshold beyond it, somewhere.
  const bool rises = r.range.to > r.range.from, holds = cell.threshold->holding == Holding::to_the_end;
  double value = cell.x();
  if (cell.threshold->holding != Holding::up_to)
    value = rises == holds ? std::max(r.range.from, r.range.to) * 1.000001 : std::min(r.range.from, r.range.to) * 0.999999;
  row.measure(value, cell.x_interval(), std::nullopt);
  if (cell.threshold->holding != Holding::up_to) row.marks = holds ? " (holds to the end)" : " (fails everywhere)";
  return row;
}

}  // namespace etendue
