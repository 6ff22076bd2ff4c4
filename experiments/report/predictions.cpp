#include "experiments/report/predictions.h"

#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

const char* const verdict_rule =
    "Confirmed: the measured interval meets the expected one; weaker or stronger: an effect of the expected direction, but "
    "less or more (a shorter time is more); refuted: no effect beyond the spread, or the opposite one; undecided: the spread "
    "reaches from no effect into what is expected. Of a count, a share, an exponent or little effect, the value must lie in "
    "the expected interval, or the measured interval hold the expected value.";

namespace {

using Row = JudgedPrediction;

std::string range_text(FigureKind kind, double low, double high) {
  return fmt::format("{}{}{}", figure_text(kind, low), low < 0 ? " to " : "–", figure_text(kind, high));
}

// Infinite ends have no cell.
TableCell end_cell(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? TableCell(*value) : TableCell();
}

// A column has its cell in a row from a function; without one the cell is a detail of the row.
struct PredictionColumn {
  TableColumn column;
  TableCell (*cell)(const Row&) = nullptr;
};

constexpr std::string_view not_confirmed = "Not confirmed:";

constexpr auto everyone = Audience::everyone, readers = Audience::people, machines = Audience::machines;

const std::vector<PredictionColumn>& columns() {
  static const std::vector<PredictionColumn> all{
      {{"id", "#"}, [](const Row& row) { return row.id > 0 ? TableCell(row.id) : TableCell(); }},
      {{"statement", "statement", false}, [](const Row& row) { return TableCell(row.statement); }},
      {{"scene", "scene", false}, [](const Row& row) { return TableCell(row.scene); }},
      {{"region", "region", false}, [](const Row& row) { return TableCell(row.region); }},
      {{"method", "method", false}, [](const Row& row) { return TableCell(row.method); }},
      {{"structure", "", false, machines}, [](const Row& row) { return TableCell(row.structure); }},
      {{"over", "over", false}, [](const Row& row) { return TableCell(row.over); }},
      {{"remedy", "remedy", false}, [](const Row& row) { return TableCell(row.remedy); }},
      {{"figure", "", false, machines}},
      {{"quantity", "quantity", false}, [](const Row& row) { return TableCell(row.quantity); }},
      {{"expected", "expected", true, readers, 1},
       [](const Row& row) {
         const auto by = row.expected ? std::optional(std::isfinite(row.expected->low) ? row.expected->low : row.expected->high)
                                      : std::nullopt;
         return TableCell::ordered(row.expected_text(), by);
       }},
      {{"expected_low", "", true, machines, 1},
       [](const Row& row) { return row.expected ? end_cell(row.expected->low) : TableCell(); }},
      {{"expected_high", "", true, machines, 1},
       [](const Row& row) { return row.expected ? end_cell(row.expected->high) : TableCell(); }},
      {{"", "measured", true, readers, 1}, [](const Row& row) { return TableCell::ordered(row.measured_text(), row.value); }},
      {{"measured", "", true, machines, 1}, [](const Row& row) { return end_cell(row.value); }},
      {{"low", "", true, machines, 1}, [](const Row& row) { return row.interval ? end_cell(row.interval->low) : TableCell(); }},
      {{"high", "", true, machines, 1},
       [](const Row& row) { return row.interval ? end_cell(row.interval->high) : TableCell(); }},
      {{"verdict", "verdict", false, everyone, 1},
       [](const Row& row) { return row.verdict ? TableCell(std::string(verdict_name(*row.verdict))) : TableCell(); }},
      {{"source", "source", false, everyone, 1}, [](const Row& row) { return TableCell(row.source); }},
      {{"seeds", "seeds", true, everyone, 2}},
      {{"iterations", "iterations", true, everyone, 2}},
      {{"points_are", "points", false, machines, 2}},
      {{"points", "points", true, everyone, 2}},
      {{"window", "window", true, readers, 2}},
      {{"from", "", true, machines, 2}},
      {{"to", "", true, machines, 2}},
      {{"plateau", "plateau (95 %)", true, everyone, 2}},
      {{"plateau_low", "", true, machines, 2}},
      {{"plateau_high", "", true, machines, 2}},
      {{"rmse", "RMSE (95 %)", true, everyone, 2}},
      {{"rmse_low", "", true, machines, 2}},
      {{"rmse_high", "", true, machines, 2}},
      {{"standard_error", "standard error", true, everyone, 2}},
      {{"stated", "stated error (RMS)", true, everyone, 2}},
      {{"true", "true error (RMS)", true, everyone, 2}}};
  return all;
}

TableCell cell_of(const PredictionColumn& column, const Row& row) {
  if (column.cell != nullptr) return column.cell(row);
  const auto found = std::ranges::find_if(row.details, [&](const auto& detail) { return detail.first == column.column.key; });
  return found == row.details.end() ? TableCell() : found->second;
}

bool is_filled(const TableCell& cell) { return !cell.raw.empty() || cell.text != TableCell().text; }

// Writes "sppm, edge of builtin:room: -0.667 (-0.68 to -0.65), expected -1/2 (refuted)".
std::string in_words(const Row& row) {
  std::string text = row.method;
  if (!row.over.empty()) text += " over " + row.over;
  text += (row.region.empty() ? " in " : fmt::format(" in {} of ", row.region)) + row.scene;
  return fmt::format("{}: {}, expected {} ({})", text, row.measured_text(), row.expected_text(), verdict_name(*row.verdict));
}

}  // namespace

std::string figure_text(FigureKind kind, double value) {
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  if (kind == FigureKind::time) return format_seconds(value);
  if (kind == FigureKind::share) return fmt::format("{:.3g} %", 100 * value);
  if (kind == FigureKind::exponent) return fmt::format("{:.3f}", value);
  return format_figure(value) + (kind == FigureKind::factor ? "×" : "");
}

void JudgedPrediction::measure(double measured, const std::optional<Interval>& around, std::optional<double> no_effect) {
  value = measured;
  interval = around;
  if (expected) verdict = around ? judge(measured, *around, *expected, no_effect) : Verdict::undecided;
}

void JudgedPrediction::add_detail(const std::string& key, double centre, const std::optional<Interval>& around) {
  details.emplace_back(key, around ? TableCell::interval(centre, around->low, around->high) : TableCell(centre));
  if (!around) return;
  details.emplace_back(key + "_low", around->low);
  details.emplace_back(key + "_high", around->high);
}

std::string JudgedPrediction::expected_text() const {
  if (!expected) return "";
  const auto& [low, high, text] = *expected;
  if (!text.empty() && kind != FigureKind::time) return text;
  if (std::isinf(high)) return "above " + figure_text(kind, low);
  if (std::isinf(low) || (low == 0 && (kind == FigureKind::factor || kind == FigureKind::time)))
    return "below " + figure_text(kind, high);
  return expected->is_value() ? figure_text(kind, low) : range_text(kind, low, high);
}

std::string JudgedPrediction::measured_text() const {
  if (!value) return problem;
  std::string text = figure_text(kind, *value);
  if (interval && interval->low < interval->high) text += fmt::format(" ({})", range_text(kind, interval->low, interval->high));
  return text + marks;
}

void Predictions::add(Predictions others) {
  rows.insert(rows.end(), others.rows.begin(), others.rows.end());
  notes.insert(notes.end(), others.notes.begin(), others.notes.end());
  order += others.order;
}

Table predictions_table(const Predictions& predictions) {
  Table table{.name = "predictions", .title = "Predictions and what was measured", .group_titles = {"Verdict", "Measurement"}};
  std::vector<const Row*> rows = mapped(predictions.rows, [](const Row& row) { return &row; });
  std::ranges::stable_sort(rows, {}, &Row::id);
  table.rows.resize(rows.size());
  for (const PredictionColumn& column : columns()) {
    std::vector<TableCell> cells = mapped(rows, [&](const Row* row) { return cell_of(column, *row); });
    if (std::ranges::none_of(cells, is_filled)) continue;
    table.columns.push_back(column.column);
    for (std::size_t i = 0; i < rows.size(); ++i) table.rows[i].push_back(std::move(cells[i]));
  }
  const auto measures = [](const TableColumn& column) { return column.group == 2 && column.audience != machines; };
  if (std::ranges::none_of(table.columns, measures)) table.group_titles.clear();
  if (rows.empty()) return table;
  table.notes = predictions.notes;
  table.notes.insert(table.notes.begin(), verdict_rule);
  if (!predictions.order.empty()) table.notes.push_back(predictions.order);
  return table;
}

std::string predictions_finding(const Predictions& predictions) {
  constexpr std::size_t most = 6;
  std::vector<Verdict> verdicts;
  std::vector<std::string> missed;
  std::size_t unmeasured = 0;
  for (const Row& row : predictions.rows) {
    unmeasured += row.expected && !row.value;
    if (!row.verdict) continue;
    verdicts.push_back(*row.verdict);
    if (*row.verdict != Verdict::confirmed) missed.push_back(in_words(row));
  }
  const auto of_expected = [](const Row& row) { return row.expected.has_value(); };
  if (std::ranges::none_of(predictions.rows, of_expected)) return {};
  if (verdicts.empty()) return "No prediction could be measured.";
  std::string text = fmt::format("{}: {}.", counted(verdicts.size(), "prediction"), count_verdicts(verdicts));
  if (unmeasured > 0) text += fmt::format(" {} could not be measured.", unmeasured);
  if (!missed.empty()) text += fmt::format(" {} {}.", not_confirmed, enumerate(missed, "; ", most));
  return text + (predictions.order.empty() ? "" : " " + predictions.order);
}

std::string predictions_answer(const Predictions& predictions) {
  const std::string text = predictions_finding({predictions.rows, {}, {}});
  return display_width(text) <= answer_width ? text : text.substr(0, text.find(fmt::format(" {}", not_confirmed)));
}

}  // namespace etendue
