// The tables of a failure map: the matrix, all thresholds, and what remedies move.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

const char* const threshold_rule =
    "A method fails where the mean of its figure over seeds leaves the interval of a sound method. The threshold is where that "
    "first happens from the harmless end on, found by bisection; its interval holds the thresholds of 95 % of repetitions with "
    "other seeds. † marks curves that recover beyond it.";

namespace {

std::string figure_of(double x) { return format_figure(x, 2); }

double value_at(const StressRecord& record, double t) {
  const auto nearest = std::ranges::min_element(record.points, {}, [&](const StressPoint& p) { return std::abs(p.t - t); });
  return mean(nearest->values);
}

TableCell held_share(const StressCell& cell) {
  return cell.threshold ? TableCell(cell.threshold->t, fmt::format("{:.0f} %", 100 * cell.threshold->t)) : TableCell();
}

}  // namespace

std::string range_of(const StressRecord& record) {
  return with_unit(fmt::format("{:g} → {:g}", record.range.from, record.range.to), record.unit);
}

std::string bound_of(const StressRecord& record) {
  const auto& [low, high, text] = record.holds;
  if (std::isinf(low) || (low == 0 && !std::isinf(high)))
    return fmt::format("{} at most {}", record.figure, format_short(high));
  if (std::isinf(high)) return fmt::format("{} at least {}", record.figure, format_short(low));
  return fmt::format("{} within {} to {}", record.figure, format_short(low), format_short(high));
}

std::string MendedCell::text() const {
  return fmt::format("{}{}×", mended.at_least ? "at least " : mended.at_most ? "at most " : "", figure_of(mended.factor));
}

std::vector<const StressCell*> all_cells(const StressMap& map) {
  std::vector<const StressCell*> cells;
  for (const StressRow& row : map.rows)
    for (const auto* of : {&row.cells, &row.remedies})
      for (const StressCell& cell : *of) cells.push_back(&cell);
  return cells;
}

Table matrix_table(const StressMap& map, bool structures) {
  const std::vector<std::string>& columns = structures ? map.structure_columns : map.columns;
  Table table{.name = structures ? "matrix-structures" : "matrix",
              .title = fmt::format("From where on {} fail", structures ? "structures" : "methods")};
  table.columns = {{"id", "#"}, {"hazard", "hazard", false}, {"parameter", "x", false}, {"range", "harmless → harmful", false}};
  for (const std::string& column : columns) table.columns.push_back({column, column});
  for (const StressRow& row : map.rows) {
    if (row.record().of_structure != structures) continue;
    auto& cells = table.rows.emplace_back(
        std::vector<TableCell>{row.id, row.record().hazard, row.record().parameter, range_of(row.record())});
    for (const std::string& column : columns) {
      const StressCell* cell = row.of(column);
      TableCell& shown = cells.emplace_back(cell ? TableCell(cell->threshold_text()) : TableCell());
      if (cell && cell->threshold) shown.order = cell->threshold->t;
    }
  }
  table.notes = {threshold_rule,
                 "holds: to the harmful end; fails: at the harmless end already; –: does not apply (thresholds.md says why)."};
  return table;
}

Table thresholds_table(const StressMap& map) {
  using Cell = const StressCell*;
  TableOf<Cell> table("thresholds", "Thresholds of failure", all_cells(map));
  const auto end = [](Cell cell, double Interval::*of) {
    const double x = cell->threshold && cell->threshold->holding == Holding::up_to ? cell->x_interval().*of : endless;
    return std::isfinite(x) ? TableCell(x) : TableCell();
  };
  table.column("id", "#", [](Cell c) { return c->record->id; });
  table.column("hazard", "hazard", [](Cell c) { return c->record->hazard; });
  table.column("method", "method", [](Cell c) { return c->record->column; });
  table.column("remedy", "remedy", [](Cell c) { return c->record->remedy; });
  table.column("holds", "sound where", [](Cell c) { return bound_of(*c->record); });
  table.column("verdict", "verdict", [](Cell c) { return c->verdict_text(); });
  table.data("threshold", [](Cell c) {
    return c->threshold && c->threshold->holding == Holding::up_to ? TableCell(c->x(), figure_of(c->x())) : TableCell();
  });
  table.data("threshold_low", [&](Cell c) { return end(c, &Interval::low); });
  table.data("threshold_high", [&](Cell c) { return end(c, &Interval::high); });
  table.column("interval", "95 %", [](Cell c) { return c->interval_cell(); });
  table.column("share", "holds along", [](Cell c) { return held_share(*c); });
  table.column("first", "figure at the harmless end",
               [](Cell c) { return c->threshold ? TableCell(value_at(*c->record, 0)) : TableCell(); });
  table.column("last", "at the harmful end",
               [](Cell c) { return c->threshold ? TableCell(value_at(*c->record, 1)) : TableCell(); });
  table.column("peak", "brightest pixel there", [](Cell c) {
    return c->threshold && !c->record->of_structure ? TableCell(c->record->points.back().peak) : TableCell();
  });
  table.data("method_at", [](Cell c) { return c->record->method; });
  table.note(threshold_rule);
  table.note("Brightest pixel: of any seed at the harmful end, over the reference's brightest.");
  return table.take();
}

std::vector<MendedCell> mended_cells(const StressMap& map) {
  std::vector<MendedCell> cells;
  for (const StressRow& row : map.rows)
    for (const StressCell& cell : row.remedies) {
      const StressCell* without = row.of(cell.record->column);
      if (!without || !without->threshold || !cell.threshold) continue;
      cells.push_back(
          {without, &cell, mended(without->record->curve(), cell.record->curve(), cell.record->holds, cell.record->range)});
    }
  return cells;
}

Table remedies_table(const std::vector<MendedCell>& cells) {
  TableOf<MendedCell> table("remedies", "By what factor remedies move thresholds", cells);
  table.column("id", "#", [](const MendedCell& c) { return c.with->record->id; });
  table.column("hazard", "hazard", [](const MendedCell& c) { return c.with->record->hazard; });
  table.column("method", "method", [](const MendedCell& c) { return c.with->record->column; });
  table.column("remedy", "remedy", [](const MendedCell& c) { return c.with->record->remedy; });
  table.column("without", "without", [](const MendedCell& c) { return c.without->verdict_text(); });
  table.column("with", "with", [](const MendedCell& c) { return c.with->verdict_text(); });
  table.column("factor", "threshold moved by",
               [](const MendedCell& c) { return c.mended.is_known() ? TableCell(c.factor(), c.text()) : TableCell(); });
  table.data("factor_low",
             [](const MendedCell& c) { return c.mended.is_known() ? TableCell(c.mended.interval.low) : TableCell(); });
  table.data("factor_high", [](const MendedCell& c) {
    return std::isfinite(c.mended.interval.high) ? TableCell(c.mended.interval.high) : TableCell();
  });
  table.column(
      "interval", "95 %",
      [](const MendedCell& c) {
        const auto& [low, high] = c.mended.interval;
        return c.mended.is_known() ? TableCell::ordered(format_interval(low, high), low) : TableCell();
      },
      Audience::people);
  table.note(
      "Above 1: towards harm. A threshold at an end of the range bounds the factor from one side; where both lie at the same "
      "end "
      "nothing is known of it.");
  return table.take();
}

}  // namespace etendue
