#include "experiments/kinds/stress/stress_report.h"

#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

namespace etendue {

namespace {

std::vector<const StressCell*> matrix_cells(const StressMap& map, bool structures) {
  std::vector<const StressCell*> cells;
  for (const StressRow& row : map.rows)
    if (row.record().of_structure == structures)
      for (const StressCell& cell : row.cells) cells.push_back(&cell);
  return cells;
}

// --- findings ---

struct Held {
  std::string column;
  std::size_t to_the_end = 0, of = 0;
  double share = 0;  // of the range, on the mean
};

// The hazards that every column was measured on: means over different ones say nothing of each other.
std::vector<const StressRow*> shared_rows(const StressMap& map, bool structures) {
  const std::vector<std::string>& columns = structures ? map.structure_columns : map.columns;
  std::vector<const StressRow*> shared;
  for (const StressRow& row : map.rows) {
    if (row.record().of_structure != structures) continue;
    const auto is_measured = [&](const std::string& column) { return row.of(column) && row.of(column)->threshold; };
    if (std::ranges::all_of(columns, is_measured)) shared.push_back(&row);
  }
  return shared;
}

std::vector<Held> held_by_column(const StressMap& map, bool structures) {
  std::vector<Held> all;
  std::vector<const StressRow*> rows = shared_rows(map, structures);
  if (rows.empty())
    for (const StressRow& row : map.rows)
      if (row.record().of_structure == structures) rows.push_back(&row);
  for (const std::string& column : structures ? map.structure_columns : map.columns) {
    Held held{.column = column};
    for (const StressRow* row : rows) {
      const StressCell* cell = row->of(column);
      if (!cell || !cell->threshold) continue;
      ++held.of;
      held.to_the_end += cell->threshold->holding == Holding::to_the_end;
      held.share += cell->threshold->t;
    }
    if (held.of == 0) continue;
    held.share /= static_cast<double>(held.of);
    all.push_back(held);
  }
  std::ranges::stable_sort(all, [](const Held& a, const Held& b) { return a.share > b.share; });
  return all;
}

std::string held_text(const Held& held) {
  return fmt::format("{} ({:.0f} % of a range on the mean, {} of {} to the end)", held.column, 100 * held.share,
                     held.to_the_end, held.of);
}

void add_widest(const StressMap& map, bool structures, KindReport& report) {
  const std::vector<Held> held = held_by_column(map, structures);
  if (held.size() < 2) return;
  std::string text = fmt::format("{} holds widest", held_text(held.front()));
  if (held.size() > 3) text += fmt::format(", then {} and {}", held_text(held[1]), held_text(held[2]));
  text += fmt::format("; {} holds least.", held_text(held.back()));
  if (!shared_rows(map, structures).empty()) text += " All were measured on these hazards.";
  report.findings.emplace_back(structures ? "Which structure holds widest" : "Which method holds widest", text);
}

std::string broken_text(const StressRow& row) {
  return fmt::format("{} breaks {} of {}", row.record().hazard, row.broken(),
                     std::ranges::count_if(row.cells, [](const StressCell& c) { return c.threshold.has_value(); }));
}

void add_worst(const StressMap& map, KindReport& report) {
  std::vector<const StressRow*> rows;
  for (const StressRow& row : map.rows)
    if (!row.record().of_structure) rows.push_back(&row);
  if (rows.size() < 2) return;
  std::ranges::stable_sort(rows, [](const auto* a, const auto* b) { return a->broken() > b->broken(); });
  report.findings.emplace_back(
      "Which hazard breaks most methods",
      fmt::format("{}; {}; the mildest, {}.", broken_text(*rows[0]), broken_text(*rows[1]), broken_text(*rows.back())));
}

// How much of the room for a sound figure is used up at the harmful end: 1 is the bound.
double used_margin(const StressCell& cell) {
  const auto& [low, high, text] = cell.record->holds;
  const double value = mean(cell.record->points.back().values);
  if (!(low > 0 || low < 0) || std::isinf(low)) return value / high;
  return std::isinf(high) ? low / value : std::abs(value - (low + high) / 2) / ((high - low) / 2);
}

void add_safest(const StressMap& map, KindReport& report) {
  std::vector<std::string> parts;
  for (const StressRow& row : map.rows) {
    if (row.record().of_structure) continue;
    std::vector<const StressCell*> cells;
    for (const StressCell& cell : row.cells)
      if (cell.threshold) cells.push_back(&cell);
    std::ranges::stable_sort(cells, {},
                             [](const StressCell* cell) { return std::pair(-cell->threshold->t, used_margin(*cell)); });
    const auto name = [](const StressCell* cell) { return cell->record->column; };
    parts.push_back(row.record().hazard + ": " + joined(cells | std::views::take(3), ", ", name));
  }
  if (!parts.empty()) report.findings.emplace_back("Three that hold longest", joined(parts, "; ") + ".");
}

void add_calm(const StressMap& map, KindReport& report) {
  std::vector<std::string> calm;
  for (const StressCell* cell : matrix_cells(map, false))
    if (const auto off = cell->calm_error())
      calm.push_back(fmt::format("{} on {} ({:+.0f} %)", cell->record->column, cell->record->hazard, 100 * *off));
  if (calm.empty()) return;
  report.findings.emplace_back(
      "Wrong, and calm",
      fmt::format("At the harmful end {} are off by more than a tenth of the image's mean while their seeds agree on it to a "
                  "fifth of that: {}.",
                  counted(calm.size(), "cell"), enumerate(calm, ", ", 6)));
}

void add_mended(std::vector<MendedCell> cells, KindReport& report) {
  std::erase_if(cells, [](const MendedCell& c) { return !c.mended.is_known(); });
  if (cells.empty()) return;
  const auto moved = std::ranges::count_if(cells, &MendedCell::helps);
  const auto to_end = std::ranges::count_if(
      cells, [](const MendedCell& c) { return c.helps() && c.with->threshold->holding == Holding::to_the_end; });
  const auto best = std::ranges::max_element(cells, {}, &MendedCell::factor),
             worst = std::ranges::min_element(cells, {}, &MendedCell::factor);
  report.findings.emplace_back(
      "What remedies move",
      fmt::format(
          "{} of {} remedies move the threshold towards harm, {} of them to the end of the range; the most: {} ({}, {}), the "
          "least: {} ({}, {}).",
          moved, cells.size(), to_end, best->with->record->remedy, best->with->record->hazard, best->text(),
          worst->with->record->remedy, worst->with->record->hazard, worst->text()));
}

void add_grids(const StressMap& map, KindReport& report) {
  std::vector<std::string> found;
  for (const StressRow& grid : map.grids) {
    report.tables.push_back(grid_table(grid));
    if (std::string finding = grid_finding(grid); !finding.empty()) found.push_back(std::move(finding));
  }
  report.tables.push_back(grid_points_table(map));
  if (!found.empty()) report.findings.emplace_back("Where two parameters decide", joined(found, " "));
}

// --- the page ---

std::string embedded_picture(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  return bytes.empty() ? std::string() : base64(bytes);
}

std::string cell_html(const StressCell& cell) {
  const StressRecord& r = *cell.record;
  std::string judged;
  if (const auto prediction = judge_stress(cell))
    judged = fmt::format("<p>Expected {}: <strong>{}</strong></p>", escape_html(prediction->expected_text()),
                         verdict_name(*prediction->verdict));
  std::string out =
      fmt::format("<article class=\"card\" id=\"{}\"><h4>{}</h4><p><strong>{}</strong>{}</p>{}", escape_html(cell.anchor()),
                  escape_html(cell.name()), escape_html(cell.verdict_text()),
                  cell.interval_text().empty() ? "" : escape_html(fmt::format(" (95 %: {})", cell.interval_text())), judged);
  const bool two = !r.after.empty();
  if (const std::string png = embedded_picture(r.picture); !png.empty())
    out += fmt::format(
        "<figure><img style=\"width:100%;image-rendering:pixelated\" alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption "
        "class=\"note\">{0}</figcaption></figure>",
        two ? "before the threshold: reference, image | after it: reference, image" : "reference, image", png);
  for (const std::string& command : {r.before, r.after})
    if (!command.empty()) out += "<pre>" + escape_html(command) + "</pre>";
  return out + "</article>\n";
}

FigureGroup hazard_group(const StressMap& map, const StressRow& row) {
  const StressRecord& r = row.record();
  FigureGroup group{.heading = fmt::format("{}. {}", r.id, r.hazard),
                    .figures = {r.y ? grid_figure(row) : curve_figure(map, row)}};
  group.below = fmt::format(
      "<p>{}. x: {}, {}. Sound: {}. <span class=\"note\">{}</span></p>\n<details><summary>The cells: images before and after "
      "each threshold, and commands that repeat them</summary><div class=\"findings\">\n",
      escape_html(r.failure), escape_html(r.parameter), escape_html(range_of(r)), escape_html(bound_of(r)),
      escape_html(r.source));
  for (const auto* cells : {&row.cells, &row.remedies})
    for (const StressCell& cell : *cells) group.below += cell_html(cell);
  group.below += "</div></details>\n";
  return group;
}

Figure matrix_figure(const StressMap& map, bool structures) {
  Figure figure{.name = structures ? "matrix-structures" : "matrix",
                .title = structures ? "From where on ray structures fail" : "From where on methods fail"};
  figure.drawing = draw_matrix(map, structures, true);
  figure.notes = {threshold_rule, "↗ marks failures that a remedy defers or ends (tables/remedies.md)."};
  return figure;
}

std::string answer_of(const StressMap& map, const Predictions& predictions) {
  const std::vector<Held> held = held_by_column(map, false);
  if (held.empty()) return {};
  std::string text = fmt::format("{} holds widest of {}", held.front().column, counted(held.size(), "method"));
  if (held.size() > 1)
    text += fmt::format(" ({:.0f} % of a range, {} {:.0f} %)", 100 * held[0].share, held[1].column, 100 * held[1].share);
  const auto worst =
      std::ranges::max_element(map.rows, {}, [](const StressRow& row) { return row.record().of_structure ? 0 : row.broken(); });
  text += "; " + broken_text(*worst);
  const auto verdicts = mapped(predictions.rows, [](const JudgedPrediction& row) { return *row.verdict; });
  return text + (verdicts.empty() ? "." : fmt::format("; predicted thresholds: {}.", count_verdicts(verdicts)));
}

}  // namespace

KindReport stress_report(const RunLog& log) {
  if (records_of<StressRecord>(log).empty()) return {};
  const StressMap map = arrange_stress(log);
  KindReport report{.id = "stress", .heading = "Where methods fail"};
  if (map.rows.empty() && map.grids.empty()) return report;
  std::set<std::string> methods;
  for (const StressRecord* record : records_of<StressRecord>(log)) methods.insert(record->column);
  report.fact = fmt::format("{}, {}", counted(map.rows.size() + map.grids.size(), "hazard"), counted(methods.size(), "method"));
  for (const StressCell* cell : all_cells(map))
    if (auto judged = judge_stress(*cell)) report.predictions.rows.push_back(std::move(*judged));
  const std::vector<MendedCell> mended = mended_cells(map);
  for (const bool structures : {false, true}) {
    if ((structures ? map.structure_columns : map.columns).empty()) continue;
    report.figures.push_back({"", {matrix_figure(map, structures)}});
    report.tables.push_back(matrix_table(map, structures));
    add_widest(map, structures, report);
  }
  add_worst(map, report);
  if (const std::string finding = predictions_finding(report.predictions); !finding.empty())
    report.findings.emplace_back("What theory predicted", finding);
  add_mended(mended, report);
  add_calm(map, report);
  add_safest(map, report);
  report.tables.push_back(thresholds_table(map));
  report.tables.push_back(remedies_table(mended));
  add_hidden(map, report);
  add_grids(map, report);
  for (const auto* rows : {&map.grids, &map.rows})
    for (const StressRow& row : *rows) report.figures.push_back(hazard_group(map, row));
  for (const std::string& line : failed_cells<StressRecord>(log)) {
    report.predictions.notes.push_back(line);
    report.section += "<p>" + escape_html(line) + "</p>\n";
  }
  report.predictions.notes.insert(report.predictions.notes.begin(), threshold_rule);
  report.answer = answer_of(map, report.predictions);
  return report;
}

std::string stress_summary(const RunLog& log) {
  std::string out;
  const StressMap map = arrange_stress(log);
  std::vector<const StressRow*> rows;
  for (const auto* of : {&map.rows, &map.grids})
    for (const StressRow& row : *of) rows.push_back(&row);
  for (const StressRow* shown : rows) {
    const StressRow& row = *shown;
    const StressRecord& r = row.record();
    out += fmt::format("{:2}  {}: {}, {}; sound: {}\n", r.id, r.hazard, r.parameter, range_of(r), bound_of(r));
    std::size_t widest = 16;
    for (const auto* cells : {&row.cells, &row.remedies})
      for (const StressCell& cell : *cells) widest = std::max(widest, std::min<std::size_t>(40, display_width(cell.name())));
    for (const auto* cells : {&row.cells, &row.remedies})
      for (const StressCell& cell : *cells) {
        std::string line = fmt::format("      {:<{}} {}", cell.name(), widest, cell.verdict_text());
        if (!cell.interval_text().empty()) line += fmt::format(" ({})", cell.interval_text());
        if (const auto judged = judge_stress(cell))
          line += fmt::format("; expected {}: {}", judged->expected_text(), verdict_name(*judged->verdict));
        out += line + "\n";
      }
  }
  for (const std::string& line : failed_cells<StressRecord>(log)) out += line + "\n";
  const KindReport report = stress_report(log);
  for (const auto& [subject, text] : report.findings) out += fmt::format("\n{}: {}\n", subject, text);
  return out;
}

}  // namespace etendue
