// The matrix of hazards and methods, drawn. The darker a cell, the sooner the method fails along the hazard's range; lightness
// alone tells, so that the figure can be printed and is safe for the colour-blind. What holds is pale blue.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/charts/chart_plot.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace etendue {

namespace {

constexpr double names_width = 292, cell_width = 78, cell_height = 42, header_height = 44, margin = 12;
constexpr std::size_t widest_parameter = 58;  // letters, with its range, in the width of names

struct Paint {
  const char *fill, *ink;
};

constexpr Paint holding{"#d7ecf6", "#0b3a53"}, blank{"none", "#808890"};
// The colours go from late to early failure.
constexpr std::array<Paint, 5> failing{
    {{"#fff2bd", "#3d2a00"}, {"#fdd071", "#3d2a00"}, {"#f79a3b", "#2b1500"}, {"#cf5a12", "#ffffff"}, {"#7a2604", "#ffffff"}}};

Paint paint_of(const StressCell* cell) {
  if (!cell || !cell->threshold) return blank;
  if (cell->threshold->holding == Holding::to_the_end) return holding;
  const double early = 1 - cell->threshold->t;
  if (cell->threshold->holding == Holding::nowhere) return failing.back();
  return failing[std::min<std::size_t>(3, static_cast<std::size_t>(4 * early))];
}

// A name in at most two lines, broken behind a hyphen.
std::string column_heading(const std::string& name, double middle) {
  const std::size_t hyphen = name.find('-');
  const std::string style = "font-size:12.5px;font-weight:600;text-anchor:middle";
  if (hyphen == std::string::npos || name.size() < 9) return drawn_text(middle, header_height - 10, name, style);
  return drawn_text(middle, header_height - 24, name.substr(0, hyphen + 1), style) +
         drawn_text(middle, header_height - 10, name.substr(hyphen + 1), style);
}

std::string draw_cell(const StressCell* cell, bool is_mended, double x, double y, bool linked) {
  const Paint paint = paint_of(cell);
  const std::string text = cell ? cell->threshold_text() + (is_mended ? " ↗" : "") : "";
  const std::string interval = cell ? cell->interval_text() : "";
  std::string out = fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"3\" style=\"fill:{}\"/>", px(x + 1),
                                px(y + 1), px(cell_width - 2), px(cell_height - 2), paint.fill);
  const std::string ink = fmt::format("text-anchor:middle;fill:{};", paint.ink);
  const double middle = x + cell_width / 2;
  const bool number = !interval.empty();
  out +=
      drawn_text(middle, y + (number ? 19 : 26), text, ink + (number ? "font-size:14.5px;font-weight:600" : "font-size:13px"));
  if (number) out += drawn_text(middle, y + 33, interval, ink + "font-size:10.5px");
  if (!cell) return out;
  out = fmt::format("<g><title>{}, {}: {}</title>{}</g>", escape_html(cell->record->hazard), escape_html(cell->record->column),
                    escape_html(cell->verdict_text()), out);
  return linked ? fmt::format("<a href=\"#{}\">{}</a>", escape_html(cell->anchor()), out) : out;
}

std::string draw_legend(double y) {
  std::string out;
  double x = margin;
  const auto entry = [&](const Paint& paint, const std::string& text) {
    out += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"22\" height=\"14\" rx=\"2\" style=\"fill:{};stroke:#9aa1a8;stroke-width:.6\"/>", px(x),
        px(y), paint.fill);
    out += drawn_text(x + 28, y + 11.5, text, "font-size:12px");
    x += 28 + text_width(text, 12) + 20;
  };
  entry(holding, "holds to the harmful end");
  constexpr std::array<const char*, 5> texts{"fails in the last quarter of the range", "third", "second", "first",
                                             "fails everywhere"};
  for (std::size_t i = 0; i < texts.size(); ++i) entry(failing[i], texts[i]);
  entry(blank, "–  does not apply");
  return out;
}

}  // namespace

std::string drawn_text(double x, double y, const std::string& text, const std::string& style) {
  return fmt::format("<text x=\"{}\" y=\"{}\" style=\"{}\">{}</text>", px(x), px(y), style, escape_html(text));
}

Drawing draw_matrix(const StressMap& map, bool structures, bool linked) {
  const std::vector<std::string>& columns = structures ? map.structure_columns : map.columns;
  Drawing drawing;
  drawing.width = std::max(1060.0, margin + names_width + cell_width * static_cast<double>(columns.size()) + margin);
  std::string& out = drawing.svg;
  const auto left = [](std::size_t c) { return margin + names_width + cell_width * static_cast<double>(c); };
  out += drawn_text(margin, header_height - 10, "hazard, and its parameter: harmless → harmful", "font-size:12px");
  for (std::size_t c = 0; c < columns.size(); ++c) out += column_heading(columns[c], left(c) + cell_width / 2);
  const std::vector<MendedCell> remedies = mended_cells(map);
  const auto is_mended = [&](const StressCell* cell) {
    return std::ranges::any_of(remedies, [&](const MendedCell& remedy) { return remedy.without == cell && remedy.helps(); });
  };
  double y = header_height;
  for (const StressRow& row : map.rows) {
    const StressRecord& r = row.record();
    if (r.of_structure != structures) continue;
    out += drawn_text(margin, y + 18, shortened(fmt::format("{}. {}", r.id, r.hazard), 44), "font-size:14px;font-weight:600");
    const std::string range = ", " + range_of(r);  // stays whole where there is no room for all
    constexpr std::size_t least_of_name = 8;
    const std::size_t room = widest_parameter - std::min(widest_parameter - least_of_name, display_width(range));
    const std::string parameter = shortened(r.parameter, room) + range;
    out += drawn_text(margin, y + 33, parameter, display_width(parameter) > 50 ? "font-size:9.5px" : "font-size:11px");
    for (std::size_t c = 0; c < columns.size(); ++c)
      out += draw_cell(row.of(columns[c]), is_mended(row.of(columns[c])), left(c), y, linked);
    out += "\n";
    y += cell_height;
  }
  out += draw_legend(y + 10);
  drawing.height = y + 34;
  return drawing;
}

}  // namespace etendue
