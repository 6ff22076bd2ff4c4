// Charts as hand-written SVG: a stand-alone file on white, or a piece of a page that takes its colours from the page's style.
//
// A series is told by colour (Okabe and Ito's palette, safe for the colour-blind), dash and marker together. Each series' group
// carries its points as data, from which the page's script reads what lies under the pointer.
#pragma once

#include "experiments/statistics/statistics.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

enum class Scale : std::uint8_t { linear, log };

struct Tick {
  double value = 0;
  std::string label;  // empty: a minor tick
};

// Ticks within [low, high], ascending, with about `most` labels: decades, or 1-2-5 where there are few, on log axes; a step of
// 1, 2 or 5 on linear ones. low < high, and low > 0 on a log axis.
std::vector<Tick> ticks(Interval range, Scale scale, int most);

// The place of `value` between the ends of the range: 0 to 1 inside it. Values at or below 0 lie at minus infinity of a log
// axis.
double position(double value, Interval range, Scale scale);

// A range that shows all values with a little air; on a log axis of the positive ones. It is never empty.
Interval padded_range(const std::vector<double>& values, Scale scale);

inline constexpr std::size_t chart_colours = 8, chart_dashes = 6, chart_markers = 8;

struct ChartPoint {
  double x = 0, y = 0;
  double low = 0, high = 0;  // equal to y: no band

  ChartPoint() = default;
  ChartPoint(double px, double py) : ChartPoint(px, py, py, py) {}
  ChartPoint(double px, double py, double from, double to) : x(px), y(py), low(from), high(to) {}
};

struct ChartSeries {
  enum class Draw : std::uint8_t {
    line,    // markers joined by a line, within a band
    dots,    // markers alone
    faint,   // small markers, pale
    stairs,  // a bold line that runs level, then down: what is reached by x
    guide,   // a thin dotted line in the series' colour, in no legend: what was fitted to it
    context  // a grey line behind the rest, in no legend
  };
  std::string key = {};     // series of one key are switched together
  std::string label = {};   // for the legend
  std::string detail = {};  // behind the label where one point is read out
  std::size_t colour = 0, dash = 0, marker = 0;
  Draw draw = Draw::line;
  std::vector<ChartPoint> points = {};

  // Colour, dash and marker that tell the `index`-th series from the others of its chart.
  void style(std::size_t index) {
    colour = index % chart_colours;
    dash = index / chart_colours % chart_dashes;
    marker = (index + index / chart_colours) % chart_markers;
  }
  bool has_marks() const { return draw == Draw::line || draw == Draw::dots || draw == Draw::faint; }
  bool is_in_legend() const { return draw != Draw::guide && draw != Draw::context && !points.empty(); }
};

struct ChartLabel {
  double x = 0, y = 0;
  std::string text;
};

struct Axis {
  std::string title = {};
  Scale scale = Scale::log;
  std::optional<Interval> range = {};  // empty: what shows every point
};

struct Chart {
  std::string title = {};  // empty: none
  Axis x = {}, y = {};
  std::vector<std::string> rows = {};  // where given, y is an index into these names, the first on top
  std::vector<ChartSeries> series = {};
  std::vector<ChartLabel> labels = {};  // placed beside their points where there is room
};

// A picture that is drawn otherwise than as a chart: elements of SVG within a box, in pixels.
struct Drawing {
  std::string svg;
  double width = 0, height = 0;
};

// These are the ranges a chart takes by itself, with which panels can share axes.
Interval natural_x_range(const Chart& chart);
Interval natural_y_range(const Chart& chart);

// Draws the plot without legend, for a page; `compact` is for one of several panels. Text in it is escaped.
std::string inline_svg(const Chart& chart, bool compact = false);

std::string inline_svg(const Drawing& drawing, const std::string& title);

// Draws a file of its own: title, panels (one, or several in a grid), legend, notes.
std::string standalone_svg(const std::string& title, std::span<const Chart> panels, const std::vector<std::string>& notes);
std::string standalone_svg(const std::string& title, const Drawing& drawing, const std::vector<std::string>& notes);

// The series that a legend of these panels names: one a key, in order, without those whose panel is theirs alone.
std::vector<const ChartSeries*> legend_series(std::span<const Chart> panels);
// Draws the line and marker of a series, for a legend in HTML.
std::string legend_swatch(const ChartSeries& series);

}  // namespace etendue
