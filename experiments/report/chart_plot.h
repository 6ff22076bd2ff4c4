// The inside of a chart: from points to marks in a rectangle.
#pragma once

#include "experiments/report/chart_svg.h"

namespace etendue {

// Pixels, y downwards.
struct PixelBox {
  double left = 0, top = 0, width = 0, height = 0;
  double right() const { return left + width; }
  double bottom() const { return top + height; }
  bool overlaps(const PixelBox& b) const {
    return left < b.right() && b.left < right() && top < b.bottom() && b.top < bottom();
  }
  bool inside(const PixelBox& b) const {
    return left >= b.left && right() <= b.right() && top >= b.top && bottom() <= b.bottom();
  }
};

// Estimated width of text in pixels, since no font is available.
double text_width(std::string_view text, double size);

struct PlotFrame {
  PixelBox box;  // of the data
  Interval x, y;
  Scale x_scale = Scale::log, y_scale = Scale::log;

  // Clamped to the frame from below, so that a zero on a log axis lies on its lower edge.
  dvec2 place(double px, double py) const;
};

// Fits a chart's plot, with its ticks and titles, into `outer`.
PlotFrame fit_plot(const Chart& chart, const PixelBox& outer, bool compact);

std::string draw_plot(const Chart& chart, const PlotFrame& frame, bool compact);

// The outline of a marker of radius `r`.
std::string marker_path(std::size_t marker, dvec2 at, double r);
std::string series_classes(const ChartSeries& series);

// Whether a legend need not name the series: its panel's title does, and nothing else is drawn there.
bool named_by_panel(const Chart& panel, const ChartSeries& series);

}  // namespace etendue
