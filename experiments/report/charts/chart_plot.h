// The inside of a chart: from points to marks in a rectangle.
#pragma once

#include "experiments/report/charts/chart_svg.h"
#include "framework/core/vec.h"

#include <algorithm>
#include <string>
#include <vector>

namespace etendue {

// Boxes are in pixels, y downwards.
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
  dvec2 nearest(dvec2 p) const { return {std::clamp(p.x, left, right()), std::clamp(p.y, top, bottom())}; }
  double distance(dvec2 p) const { return glm::distance(p, nearest(p)); }
};

// What lies around the labels of a plot.
struct Surroundings {
  struct Mark {
    dvec2 at;
    std::string key;  // of its series
  };
  std::vector<PixelBox> taken, lines;
  std::vector<Mark> marks;

  // Whether a label there of the mark at `at` lies nearer to the mark of another key.
  bool misleads(const PixelBox& box, dvec2 at) const;
};

class Plot {
 public:
  // Fits a chart's plot, with its ticks and titles, into `outer`; `compact` for one of several panels. Keeps a reference.
  Plot(const Chart& chart, const PixelBox& outer, bool compact);

  std::string svg() const;
  const PixelBox& box() const { return box_; }  // of the data
  // Clamped to the box from below, so that a zero on a log axis lies on its lower edge.
  dvec2 place(double x, double y) const;

 private:
  bool is_cut() const { return chart_.y.scale == Scale::linear && chart_.y.range; }
  std::string axes() const;
  std::string line_path(const ChartSeries& series) const;
  std::string band_path(const ChartSeries& series) const;
  std::string markers(const ChartSeries& series) const;
  std::string point_data(const ChartSeries& series) const;
  std::string draw(const ChartSeries& series) const;
  Surroundings surroundings() const;
  std::string labels() const;

  const Chart& chart_;
  bool compact_;
  PixelBox box_;
  Interval x_, y_;
  Scale y_scale_;
  std::vector<Tick> x_ticks_, y_ticks_;
};

// Writes a coordinate to a tenth of a pixel.
std::string px(double value);
// Writes "M1 2L3 4L5 6".
std::string polyline(std::span<const dvec2> points);
// Estimated width of text in pixels, since no font is available.
double text_width(std::string_view text, double size);

// Draws the outline of a marker of radius `r`.
std::string marker_path(std::size_t marker, dvec2 at, double r);
std::string series_classes(const ChartSeries& series);

}  // namespace etendue
