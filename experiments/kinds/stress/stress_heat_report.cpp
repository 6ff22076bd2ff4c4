// The heat map of a hazard with two parameters: the figure over (x, y), both on logarithmic axes.
//
// A row is a sweep along x at one y; each of its points colours what lies nearer to it than to the next, so that the map is
// fine where the bisection went, at the boundary, and no colour is between measurements. Pale blue is sound, yellow to brown
// is not: lightness falls with the error, so that the map can be printed. The measured boundary goes through the thresholds,
// with their 95 % intervals; the predicted one is dashed, linear between rows on these axes, which a power law is.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/charts/chart_plot.h"
#include "experiments/report/page/images.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace etendue {

namespace {

constexpr const char *measured_ink = "#101820", *predicted_ink = "#1668e3", *dashes = "stroke-dasharray:7 6;";

std::string titled(const std::string& axis, const std::string& unit) { return unit.empty() ? axis : axis + ", " + unit; }

// --- colours ---

constexpr std::array sound_colours{0xf4fafd, 0xbeddee};
constexpr std::array failing_colours{0xfff0b2, 0xfdd071, 0xf79a3b, 0xcf5a12, 0x6e2002};

// Colours by how far the figure lies beyond its bounds, over the farthest of the points on the same side.
class Palette {
 public:
  explicit Palette(const StressRow& grid) : holds_(grid.record().holds) {
    std::vector<double> values;
    for (const StressCell& cell : grid.cells)
      for (const StressPoint& point : cell.record->points) values.push_back(mean(point.values));
    const auto [low, high] = std::ranges::minmax(values);
    range = {low, high};
    scale = low > 0 && holds_.high > 0 && !(holds_.low < 0 && std::isfinite(holds_.low)) ? Scale::log : Scale::linear;
    for (const double value : values) {
      const double by = excess(value, holds_);
      worst_ = std::max(worst_, by);
      if (by > -immeasurable) calmest_ = std::min(calmest_, by);
    }
  }

  std::string of(double value) const {
    const double by = excess(value, holds_);
    if (by > 0) return colour_among(failing_colours, worst_ > 0 ? std::min(1.0, by / worst_) : 0);
    return colour_among(sound_colours, calmest_ < 0 ? std::max(0.0, 1 - by / calmest_) : 1);
  }

  Interval range;
  Scale scale = Scale::log;

 private:
  static constexpr double immeasurable = 1e100;

  Expected holds_;
  double calmest_ = 0, worst_ = 0;  // of the points
};

// --- the map ---

class HeatMap {
 public:
  explicit HeatMap(const StressRow& grid) : grid_(grid), palette_(grid) {
    const SweepRange& range = grid.record().range;
    x_ = {std::min(range.from, range.to), std::max(range.from, range.to)};
    const auto& cells = grid.cells;
    for (std::size_t i = 0; i + 1 < cells.size(); ++i) edges_.push_back(std::sqrt(y_of(i) * y_of(i + 1)));
    const double first = cells.size() > 1 ? y_of(0) / edges_.front() : 1 / 1.2, last = 1 / first;
    edges_.insert(edges_.begin(), y_of(0) * first);
    edges_.push_back(cells.size() > 1 ? y_of(cells.size() - 1) * (y_of(cells.size() - 1) / edges_.back()) : y_of(0) * last);
    height_ = row_height * static_cast<double>(cells.size());
  }

  Drawing draw() const {
    Drawing drawing{.svg = {}, .width = width, .height = 0};
    std::string& out = drawing.svg;
    for (std::size_t i = 0; i < grid_.cells.size(); ++i) out += draw_row(i);
    out += axes();
    out += boundary(measured(), measured_ink, 2.6, "");
    out += boundary(predicted(), predicted_ink, 2, dashes);
    out += marks();
    out += legend(top + height_ + 52);
    drawing.height = top + height_ + 132;
    return drawing;
  }

 private:
  double y_of(std::size_t row) const { return *grid_.cells[row].record->y; }
  double px_of(double x) const { return left + plot_width * std::clamp(position(x, x_, Scale::log), 0.0, 1.0); }
  double py_of(double y) const { return top + height_ * (1 - position(y, {edges_.front(), edges_.back()}, Scale::log)); }

  std::string draw_row(std::size_t row) const {
    const StressCell& cell = grid_.cells[row];
    const StressRecord& r = *cell.record;
    const double above = py_of(edges_[row + 1]), below = py_of(edges_[row]);
    std::string out;
    for (std::size_t i = 0; i < r.points.size(); ++i) {
      const auto border = [&](std::size_t a, std::size_t b) { return px_of(std::sqrt(r.points[a].x * r.points[b].x)); };
      const double begin = i > 0 ? border(i - 1, i) : px_of(r.range.from),
                   end = i + 1 < r.points.size() ? border(i, i + 1) : px_of(r.range.to);
      const double value = mean(r.points[i].values);
      out += fmt::format(
          "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:{}\" shape-rendering=\"crispEdges\"><title>{} {}, "
          "{}: {} {}</title></rect>",
          px(std::min(begin, end)), px(above), px(std::abs(end - begin) + seam), px(below - above + seam), palette_.of(value),
          escape_html(r.parameter), with_unit(format_figure(r.points[i].x), r.unit), escape_html(cell.name()),
          escape_html(r.figure), format_figure(value));
      out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"1.4\" style=\"fill:#000;fill-opacity:.3\"/>",
                         px(px_of(r.points[i].x)), px(py_of(y_of(row))));
    }
    return out + "\n";
  }

  std::vector<dvec2> predicted() const {
    std::vector<dvec2> at;
    for (const StressCell& cell : grid_.cells)
      if (const StressRecord& r = *cell.record; r.is_expected && r.expected_low && x_.contains(*r.expected_low))
        at.emplace_back(px_of(*r.expected_low), py_of(*r.y));
    return at;
  }

  std::vector<dvec2> measured() const {
    std::vector<dvec2> at;
    for (const StressCell& cell : grid_.cells)
      if (cell.threshold && cell.threshold->holding == Holding::up_to) at.emplace_back(px_of(cell.x()), py_of(*cell.record->y));
    return at;
  }

  // Edged with white, so that the one is seen on the other and both on any colour.
  static std::string boundary(const std::vector<dvec2>& at, const char* ink, double stroke, const char* style) {
    if (at.empty()) return {};
    const std::string path = polyline(at);
    return fmt::format(
        "<path d=\"{0}\" style=\"fill:none;stroke:#fff;stroke-width:{1};{3}\"/>"
        "<path d=\"{0}\" style=\"fill:none;stroke:{2};stroke-width:{4};{3}\"/>\n",
        path, px(stroke + 2.4), ink, style, px(stroke));
  }

  // Thresholds with their intervals.
  std::string marks() const {
    std::string out;
    for (const StressCell& cell : grid_.cells) {
      if (!cell.threshold || cell.threshold->holding != Holding::up_to) continue;
      const Interval x = cell.x_interval();
      const double y = py_of(*cell.record->y), from = px_of(std::max(x.low, x_.low)), to = px_of(std::min(x.high, x_.high));
      out += fmt::format(
          "<path d=\"M{0} {1}L{2} {1}M{0} {3}L{0} {4}M{2} {3}L{2} {4}\" style=\"stroke:{5};stroke-width:1.3\"/>"
          "<circle cx=\"{6}\" cy=\"{1}\" r=\"3.6\" style=\"fill:{5};stroke:#fff\"/>",
          px(from), px(y), px(to), px(y - 4), px(y + 4), measured_ink, px(px_of(cell.x())));
    }
    return out + "\n";
  }

  std::string axes() const {
    const StressRecord& r = grid_.record();
    const double bottom = top + height_;
    std::string out = fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:none;stroke:#808890\"/>",
                                  px(left), px(top), px(plot_width), px(height_));
    for (const Tick& tick : ticks(x_, Scale::log, 6)) {
      const double x = px_of(tick.value);
      out += fmt::format("<path d=\"M{0} {1}v{2}\" style=\"stroke:#808890\"/>", px(x), px(bottom), tick.label.empty() ? 3 : 6);
      if (!tick.label.empty()) out += drawn_text(x, bottom + 19, tick.label, "font-size:12.5px;text-anchor:middle");
    }
    for (const StressCell& cell : grid_.cells)
      out += drawn_text(left - 7, py_of(*cell.record->y) + 4, y_text(*cell.record->y), "font-size:12.5px;text-anchor:end");
    const bool rises = r.range.to > r.range.from;
    out += drawn_text(left + plot_width / 2, bottom + 38,
                      fmt::format("{}: harm grows to the {}", titled(r.parameter, r.unit), rises ? "right" : "left"),
                      "font-size:13px;text-anchor:middle");
    return out + fmt::format(
                     "<text transform=\"translate(14 {}) rotate(-90)\" style=\"font-size:13px;text-anchor:middle\">{}</text>\n",
                     px(top + height_ / 2), escape_html(titled(r.second, r.second_unit)));
  }

  // The colours with the figure's values, and what the lines are.
  std::string legend(double y) const {
    constexpr int steps = 60;
    const StressRecord& r = grid_.record();
    std::string out;
    Interval range = palette_.range;
    if (range.low == range.high) range.high = range.low + 1;
    for (int i = 0; i < steps; ++i) {
      const double t = (i + 0.5) / steps;
      const double value = palette_.scale == Scale::log ? range.low * std::pow(range.high / range.low, t)
                                                        : range.low + t * (range.high - range.low);
      out +=
          fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"10\" style=\"fill:{}\" shape-rendering=\"crispEdges\"/>",
                      px(left + plot_width * i / steps), px(y), px(plot_width / steps + 0.6), palette_.of(value));
    }
    for (const Tick& tick : ticks(range, palette_.scale, 5))
      if (!tick.label.empty())
        out += drawn_text(left + plot_width * position(tick.value, range, palette_.scale), y + 23, tick.label,
                          "font-size:11.5px;text-anchor:middle");
    out += drawn_text(left, y + 42, fmt::format("{}; sound: {}", r.figure_text, bound_of(r)), "font-size:12.5px");
    double x = left;
    const auto entry = [&](const std::string& text, const char* ink, const char* style) {
      // On the map's own ground, for pages may be dark.
      out += fmt::format("<path d=\"M{} {}h30\" style=\"stroke:#f4fafd;stroke-width:12\"/>", px(x - 2), px(y + 57));
      out += fmt::format("<path d=\"M{} {}h26\" style=\"stroke:{};stroke-width:2.2;{}\"/>", px(x), px(y + 57), ink, style);
      out += drawn_text(x + 32, y + 61, text, "font-size:12.5px");
      x += 32 + text_width(text, 12.5) + 20;
    };
    entry("measured, with 95 %", measured_ink, "");
    if (!predicted().empty()) entry("predicted", predicted_ink, dashes);
    return out;
  }

  static constexpr double left = 74, top = 14, seam = 0.6, plot_width = 440, row_height = 34, width = 532;

  const StressRow& grid_;
  Palette palette_;
  Interval x_;
  std::vector<double> edges_;  // of rows, ascending
  double height_ = 0;
};

TableCell point_cell(const StressRecord& r, double t) {
  const auto found = std::ranges::find_if(r.points, [&](const StressPoint& p) { return std::abs(p.t - t) < 1e-9; });
  if (found == r.points.end()) return {};
  const double figure = mean(found->values);
  return {figure, format_figure(figure) + (is_failed(*found, r.holds) ? " ✗" : "")};
}

std::string row_verdict(const StressCell& cell) {
  const auto judged = judge_stress(cell);
  return judged && judged->verdict ? std::string(verdict_name(*judged->verdict)) : "";
}

struct GridPoint {
  const StressCell* cell;
  const StressPoint* point;
};

}  // namespace

Figure grid_figure(const StressRow& grid) {
  const StressRecord& of = grid.record();
  const bool any = std::ranges::any_of(grid.cells, [](const StressCell& cell) { return cell.threshold.has_value(); });
  if (!any) return {};
  return {.name = fmt::format("{}-{}", of.cell.accel, slug(of.hazard)),
          .scene = of.hazard,
          .title = fmt::format("{}: {} of {}", of.hazard, of.figure, of.column),
          .notes = {"Each point of a sweep colours what lies nearest to it along its row; the smallest dots are the points. "
                    "Black: the thresholds with their 95 % intervals. Dashed: where theory expects them."},
          .drawing = HeatMap(grid).draw()};
}

Table grid_table(const StressRow& grid) {
  const StressRecord& of = grid.record();
  TableOf<StressCell> table(fmt::format("map-{:02}", of.id), of.hazard + ": " + of.figure, grid.cells);
  table.column("y", titled(of.second, of.second_unit), [](const StressCell& c) { return *c.record->y; });
  for (int quarter = 0; quarter <= 4; ++quarter) {
    const double t = quarter / 4.0;
    table.column(fmt::format("at_{:g}", of.range.at(t)), fmt::format("x = {}", x_text(of.range.at(t))),
                 [&](const StressCell& c) { return point_cell(*c.record, t); });
  }
  table.column("expected", "expected", [](const StressCell& c) { return c.record->expected_low; });
  table.column("verdict", "fails", [](const StressCell& c) { return c.verdict_text(); });
  table.column("interval", "95 %", [](const StressCell& c) { return c.interval_cell(); });
  table.column("judged", "prediction", row_verdict);
  table.note(fmt::format("x: {}, {}. Sound: {}; ✗ marks what is not.", of.parameter, range_of(of), bound_of(of)));
  table.note("Prediction: " + of.source + ". It is confirmed where the interval holds it.");
  return table.take();
}

Table grid_points_table(const StressMap& map) {
  std::vector<GridPoint> points;
  for (const StressRow& grid : map.grids)
    for (const StressCell& cell : grid.cells)
      for (const StressPoint& point : cell.record->points) points.push_back({&cell, &point});
  TableOf<GridPoint> table("map-points", "Every point of the heat maps", points);
  const auto extreme = [](const GridPoint& p, bool high) {
    const auto [least, most] = std::ranges::minmax(p.point->values);
    return high ? most : least;
  };
  table.column("id", "#", [](const GridPoint& p) { return p.cell->record->id; });
  table.column("hazard", "hazard", [](const GridPoint& p) { return p.cell->record->hazard; });
  table.column("method", "method", [](const GridPoint& p) { return p.cell->record->column; });
  table.column("x", "x", [](const GridPoint& p) { return p.point->x; });
  table.column("y", "y", [](const GridPoint& p) { return *p.cell->record->y; });
  table.column("figure", "figure", [](const GridPoint& p) { return p.cell->record->figure; });
  table.column("mean", "mean", [](const GridPoint& p) { return mean(p.point->values); });
  table.column("low", "least of a seed", [&](const GridPoint& p) { return extreme(p, false); });
  table.column("high", "most", [&](const GridPoint& p) { return extreme(p, true); });
  table.column("fails", "fails", [](const GridPoint& p) { return is_failed(*p.point, p.cell->record->holds) ? "yes" : "no"; });
  return table.take();
}

std::string grid_finding(const StressRow& grid) {
  std::size_t judged_rows = 0;
  std::vector<std::string> off;
  for (const StressCell& cell : grid.cells) {
    const auto judged = judge_stress(cell);
    if (!judged || !judged->verdict) continue;
    ++judged_rows;
    if (*judged->verdict != Verdict::confirmed) off.push_back(y_text(*cell.record->y));
  }
  if (judged_rows == 0) return {};
  const StressRecord& of = grid.record();
  return fmt::format("{} ({}): the predicted boundary lies in the measured interval in {} of {} rows{}.", of.hazard, of.column,
                     judged_rows - off.size(), judged_rows,
                     off.empty() ? "" : fmt::format(", not at {} = {}", of.second, joined(off, ", ")));
}

}  // namespace etendue
