#include "experiments/report/chart_plot.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace etendue {
namespace {

constexpr double font = 13, small_font = 12;

// One decimal is a tenth of a pixel; trailing zeros are left out, for there are many of these.
std::string px(double value) {
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view classes, std::string_view text) {
  return fmt::format("<text x=\"{}\" y=\"{}\"{}{}>{}</text>", px(x), px(y),
                     anchor.empty() ? "" : fmt::format(" text-anchor=\"{}\"", anchor),
                     classes.empty() ? "" : fmt::format(" class=\"{}\"", classes), escape_html(text));
}

int most_labels(double pixels, double each) { return std::max(2, static_cast<int>(pixels / each)); }

std::vector<Tick> x_ticks(const PlotFrame& frame) { return ticks(frame.x, frame.x_scale, most_labels(frame.box.width, 70)); }
std::vector<Tick> y_ticks(const PlotFrame& frame) { return ticks(frame.y, frame.y_scale, most_labels(frame.box.height, 36)); }

std::string draw_axes(const Chart& chart, const PlotFrame& frame) {
  const PixelBox& box = frame.box;
  std::string grid, labels;
  for (const Tick& tick : x_ticks(frame)) {
    const double x = box.left + box.width * position(tick.value, frame.x, frame.x_scale);
    grid += fmt::format("<path class=\"{}\" d=\"M{} {}V{}\"/>", tick.label.empty() ? "minor" : "grid", px(x), px(box.top),
                        px(box.bottom()));
    if (!tick.label.empty()) labels += text_at(x, box.bottom() + 18, "middle", "", tick.label);
  }
  if (chart.rows.empty()) {
    for (const Tick& tick : y_ticks(frame)) {
      const double y = box.bottom() - box.height * position(tick.value, frame.y, frame.y_scale);
      const bool zero = frame.y_scale == Scale::linear && tick.value == 0;
      grid += fmt::format("<path class=\"{}\" d=\"M{} {}H{}\"/>",
                          zero                 ? "zero"
                          : tick.label.empty() ? "minor"
                                               : "grid",
                          px(box.left), px(y), px(box.right()));
      if (!tick.label.empty()) labels += text_at(box.left - 8, y + 4.5, "end", "", tick.label);
    }
  } else {
    for (std::size_t row = 0; row < chart.rows.size(); ++row) {
      const double y = frame.place(frame.x.low, static_cast<double>(row)).y;
      grid += fmt::format("<path class=\"grid\" d=\"M{} {}H{}\"/>", px(box.left), px(y), px(box.right()));
      labels += text_at(box.left - 8, y + 4.5, "end", "", shortened(chart.rows[row], 28));
    }
  }
  std::string out = "<g class=\"axes\">" + grid;
  out += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", px(box.left), px(box.top),
                     px(box.width), px(box.height));
  out += labels + text_at(box.left + box.width / 2, box.bottom() + 40, "middle", "axis-title", chart.x.title);
  if (!chart.y.title.empty()) out += text_at(box.left, box.top - 9, "start", "axis-title", chart.y.title);
  return out + "</g>\n";
}

bool marks_zero(const PlotFrame& frame, const ChartPoint& point) { return frame.y_scale == Scale::log && point.y <= 0; }

std::string line_path(const ChartSeries& series, const PlotFrame& frame) {
  std::string d;
  for (const ChartPoint& point : series.points) {
    const dvec2 at = frame.place(point.x, point.y);
    if (series.draw == ChartSeries::Draw::stairs && !d.empty())
      d += fmt::format("H{}V{}", px(at.x), px(at.y));
    else
      d += fmt::format("{}{} {}", d.empty() ? "M" : "L", px(at.x), px(at.y));
  }
  if (series.draw == ChartSeries::Draw::stairs && !d.empty()) d += "H" + px(frame.box.right());
  return d;
}

std::string band_path(const ChartSeries& series, const PlotFrame& frame) {
  std::string d;
  bool any = false;
  for (const ChartPoint& point : series.points) {
    const dvec2 at = frame.place(point.x, point.high);
    d += fmt::format("{}{} {}", d.empty() ? "M" : "L", px(at.x), px(at.y));
    any = any || point.high > point.low;
  }
  if (!any) return {};
  if (series.points.size() == 1) {  // no width to fill: a bar
    const dvec2 low = frame.place(series.points[0].x, series.points[0].low);
    return fmt::format("M{} {}", px(low.x - 3), d.substr(d.find(' ') + 1)) + fmt::format("h6V{}h-6z", px(low.y));
  }
  for (auto point = series.points.rbegin(); point != series.points.rend(); ++point) {
    const dvec2 at = frame.place(point->x, point->low);
    d += fmt::format("L{} {}", px(at.x), px(at.y));
  }
  return d + "Z";
}

// Markers on at most about twenty points of a line: more run into each other.
std::string markers(const ChartSeries& series, const PlotFrame& frame, double radius) {
  const bool all = series.draw != ChartSeries::Draw::line;
  const std::size_t stride = all ? 1 : (series.points.size() + 19) / 20;
  std::string d, zeros;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const ChartPoint& point = series.points[i];
    const dvec2 at = frame.place(point.x, point.y);
    if (marks_zero(frame, point))
      zeros += fmt::format("M{} {}h12l-6 8z", px(at.x - 6), px(at.y - 9));
    else if ((series.points.size() - 1 - i) % std::max<std::size_t>(1, stride) == 0)
      d += marker_path(series.marker, at, radius);
  }
  std::string out;
  if (!d.empty()) out += fmt::format("<path class=\"mark\" d=\"{}\"/>", d);
  if (!zeros.empty()) out += fmt::format("<path class=\"mark open\" d=\"{}\"/>", zeros);
  return out;
}

// x y low high in data, for the page's read-outs: "x,y,low,high;...", the band left out where there is none.
std::string point_data(const ChartSeries& series, const PlotFrame& frame) {
  std::string data;
  for (const ChartPoint& point : series.points) {
    const dvec2 at = frame.place(point.x, point.y);
    if (at.y < frame.box.top) continue;  // cut off, so not to be pointed at
    data += fmt::format("{}{},{},{:.4g},{:.4g}", data.empty() ? "" : ";", px(at.x), px(at.y), point.x, point.y);
    if (point.high > point.low) data += fmt::format(",{:.3g},{:.3g}", point.low, point.high);
  }
  return data;
}

std::string draw_series(const ChartSeries& series, const PlotFrame& frame, bool compact) {
  using Draw = ChartSeries::Draw;
  if (series.points.empty()) return {};
  if (series.draw == Draw::context) return fmt::format("<path class=\"line context\" d=\"{}\"/>\n", line_path(series, frame));
  std::string out =
      fmt::format("<g class=\"{}\" data-key=\"{}\" data-label=\"{}\" data-p=\"{}\">", series_classes(series),
                  escape_html(series.key), escape_html(series.label + (series.detail.empty() ? "" : " " + series.detail)),
                  series.draw == Draw::guide ? "" : point_data(series, frame));
  if (series.draw == Draw::line)
    if (const std::string band = band_path(series, frame); !band.empty())
      out += fmt::format("<path class=\"band\" d=\"{}\"/>", band);
  if (series.draw == Draw::line || series.draw == Draw::stairs || series.draw == Draw::guide)
    if (series.points.size() > 1 || series.draw == Draw::stairs)
      out += fmt::format("<path class=\"line\" d=\"{}\"/>", line_path(series, frame));
  const double radius = series.draw == Draw::faint ? 2.6 : series.draw == Draw::dots ? 5 : compact ? 3.2 : 4;
  if (series.draw != Draw::stairs && series.draw != Draw::guide) out += markers(series, frame, radius);
  return out + "</g>\n";
}

// Labels beside their points, each at the first place where it meets neither a mark nor another label; one that finds no room
// is left to the legend.
std::string draw_labels(const Chart& chart, const PlotFrame& frame) {
  std::vector<PixelBox> taken, lines;
  for (const ChartSeries& series : chart.series) {
    dvec2 last{0};
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const dvec2 at = frame.place(series.points[i].x, series.points[i].y);
      if (series.draw == ChartSeries::Draw::stairs && i > 0) {
        lines.push_back({std::min(last.x, at.x), last.y - 2, std::abs(at.x - last.x), 4});
        lines.push_back({at.x - 2, std::min(last.y, at.y), 4, std::abs(at.y - last.y)});
      } else if (series.draw < ChartSeries::Draw::stairs) {
        taken.push_back({at.x - 4, at.y - 4, 8, 8});
      }
      last = at;
    }
  }
  std::string out;
  for (const ChartLabel& label : chart.labels) {
    const dvec2 at = frame.place(label.x, label.y);
    if (at.y < frame.box.top) continue;
    const std::string text = shortened(label.text, 40);
    const double width = text_width(text, small_font), height = small_font + 2;
    std::optional<PixelBox> chosen;
    for (const bool avoid_lines : {true, false}) {
      for (const double distance : {9.0, 20.0, 34.0}) {
        const double left = at.x - width - distance, right = at.x + distance, middle = at.x - width / 2;
        const double level = at.y - height / 2, above = at.y - distance - height, below = at.y + distance;
        for (const dvec2 corner : {dvec2(right, above), dvec2(right, level), dvec2(left, below), dvec2(left, level),
                                   dvec2(right, below), dvec2(left, above), dvec2(middle, above), dvec2(middle, below)}) {
          const PixelBox box{corner.x, corner.y, width, height};
          const auto meets = [&](const PixelBox& other) { return other.overlaps(box); };
          if (!box.inside(frame.box) || std::any_of(taken.begin(), taken.end(), meets)) continue;
          if (avoid_lines && std::any_of(lines.begin(), lines.end(), meets)) continue;
          chosen = box;
          break;
        }
        if (chosen) break;
      }
      if (chosen) break;
    }
    if (!chosen) continue;
    taken.push_back(*chosen);
    const double nearest_x = std::clamp(at.x, chosen->left, chosen->right());
    const double nearest_y = std::clamp(at.y, chosen->top, chosen->bottom());
    if (std::hypot(at.x - nearest_x, at.y - nearest_y) > 14)
      out += fmt::format("<path class=\"leader\" d=\"M{} {}L{} {}\"/>", px(at.x), px(at.y), px(nearest_x), px(nearest_y));
    out += text_at(chosen->left, chosen->bottom() - 3.5, "", "label", text);
  }
  return out;
}

}  // namespace

double text_width(std::string_view text, double size) { return 0.56 * size * static_cast<double>(display_width(text)); }

std::string marker_path(std::size_t marker, dvec2 at, double r) {
  const auto polygon = [&](std::initializer_list<dvec2> corners) {
    std::string d;
    for (const dvec2& corner : corners)
      d += fmt::format("{}{} {}", d.empty() ? "M" : "L", px(at.x + r * corner.x), px(at.y + r * corner.y));
    return d + "z";
  };
  switch (marker % chart_markers) {
    case 0:
      return fmt::format("M{} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0z", px(at.x - r), px(at.y), fmt::arg("r", px(r)),
                         fmt::arg("d", px(2 * r)));
    case 1:
      return polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
    case 2:
      return polygon({{0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}});
    case 3:
      return polygon({{0, -1.3}, {1.1, 0}, {0, 1.3}, {-1.1, 0}});
    case 4:
      return polygon({{0, 1.2}, {1.1, -0.8}, {-1.1, -0.8}});
    case 5:  // plus
      return polygon({{-0.4, -1.2},
                      {0.4, -1.2},
                      {0.4, -0.4},
                      {1.2, -0.4},
                      {1.2, 0.4},
                      {0.4, 0.4},
                      {0.4, 1.2},
                      {-0.4, 1.2},
                      {-0.4, 0.4},
                      {-1.2, 0.4},
                      {-1.2, -0.4},
                      {-0.4, -0.4}});
    case 6:  // cross
      return polygon({{-1.1, -0.6},
                      {-0.6, -1.1},
                      {0, -0.5},
                      {0.6, -1.1},
                      {1.1, -0.6},
                      {0.5, 0},
                      {1.1, 0.6},
                      {0.6, 1.1},
                      {0, 0.5},
                      {-0.6, 1.1},
                      {-1.1, 0.6},
                      {-0.5, 0}});
    default:  // hourglass
      return polygon({{-1, -1}, {1, -1}, {-1, 1}, {1, 1}});
  }
}

std::string series_classes(const ChartSeries& series) {
  constexpr const char* draws[] = {"", " dots", " faint", " stairs", " guide", " context"};
  return fmt::format("series c{} d{}{}", series.colour % chart_colours, series.dash % chart_dashes,
                     draws[static_cast<std::size_t>(series.draw)]);
}

dvec2 PlotFrame::place(double px_value, double py_value) const {
  const double fx = position(px_value, x, x_scale), fy = position(py_value, y, y_scale);
  return {box.left + box.width * std::clamp(fx, -10.0, 11.0), box.bottom() - box.height * std::clamp(fy, 0.0, 10.0)};
}

PlotFrame fit_plot(const Chart& chart, const PixelBox& outer, bool compact) {
  PlotFrame frame;
  frame.x_scale = chart.x.scale;
  frame.y_scale = chart.rows.empty() ? chart.y.scale : Scale::linear;
  frame.x = chart.x.range.value_or(natural_x_range(chart));
  frame.y = chart.y.range.value_or(natural_y_range(chart));
  const double top = (chart.title.empty() ? 0 : 20) + (chart.y.title.empty() ? 10 : 26);
  frame.box = {outer.left, outer.top + top, outer.width, outer.height - top - (chart.x.title.empty() ? 26 : 48)};
  double widest = 0;
  if (chart.rows.empty())
    for (const Tick& tick : y_ticks(frame)) widest = std::max(widest, text_width(tick.label, font));
  for (const std::string& row : chart.rows) widest = std::max(widest, text_width(shortened(row, 28), font));
  // Some air: a page sets its figures larger on a narrow screen.
  const double left = 16 + widest * (chart.rows.empty() && !compact ? 1.3 : 1.05), right = 16;
  frame.box.left += left;
  frame.box.width -= left + right;
  return frame;
}

std::string draw_plot(const Chart& chart, const PlotFrame& frame, bool compact) {
  std::string out;
  if (!chart.title.empty())
    out += text_at(frame.box.left, frame.box.top - (chart.y.title.empty() ? 10 : 30), "start", "panel-title",
                   shortened(chart.title, 44));
  out += draw_axes(chart, frame);
  const PixelBox& box = frame.box;
  // A nested svg clips without an id, which would have to be unique in the page. A little larger: markers on the edge stay
  // whole, unless the axis was cut there.
  const double above = chart.y.scale == Scale::linear && chart.y.range ? 0 : 6;
  const std::string clip =
      fmt::format("{} {} {} {}", px(box.left - 6), px(box.top - above), px(box.width + 12), px(box.height + above));
  out += fmt::format("<svg class=\"plot\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" viewBox=\"{}\">\n", px(box.left - 6),
                     px(box.top - above), px(box.width + 12), px(box.height + above), clip);
  for (const bool behind : {true, false})
    for (const ChartSeries& series : chart.series)
      if ((series.draw == ChartSeries::Draw::context || series.draw == ChartSeries::Draw::faint) == behind)
        out += draw_series(series, frame, compact);
  return out + draw_labels(chart, frame) + "</svg>\n";
}

bool named_by_panel(const Chart& panel, const ChartSeries& series) {
  using Draw = ChartSeries::Draw;
  return series.label == panel.title && std::count_if(panel.series.begin(), panel.series.end(), [](const ChartSeries& s) {
                                          return s.draw != Draw::context && s.draw != Draw::guide && !s.points.empty();
                                        }) == 1;
}

}  // namespace etendue
