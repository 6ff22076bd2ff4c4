#include "experiments/report/charts/chart_plot.h"

#include "experiments/report/report_text.h"
#include "framework/core/lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

using Draw = ChartSeries::Draw;

constexpr double font = 13, small_font = 12;

std::string text_at(double x, double y, std::string_view anchor, std::string_view classes, std::string_view text) {
  return fmt::format(R"(<text x="{}" y="{}"{}{}>{}</text>)", px(x), px(y),
                     anchor.empty() ? "" : fmt::format(R"( text-anchor="{}")", anchor),
                     classes.empty() ? "" : fmt::format(R"( class="{}")", classes), escape_html(text));
}

std::vector<Tick> fitting_ticks(Interval range, Scale scale, double pixels, double each) {
  return ticks(range, scale, std::max(2, static_cast<int>(pixels / each)));
}

// The part of a polygon that lies below a level.
std::vector<dvec2> part_below(const std::vector<dvec2>& outline, double level) {
  std::vector<dvec2> kept;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const dvec2 a = outline[i], b = outline[(i + 1) % outline.size()];
    if (a.y >= level) kept.push_back(a);
    if ((a.y < level) != (b.y < level)) kept.push_back(glm::mix(a, b, (level - a.y) / (b.y - a.y)));
  }
  return kept;
}

// A place beside `at` for a label of this size, the nearest inside the plot where is_free(box).
template <class IsFree>
std::optional<PixelBox> label_place(dvec2 at, double width, double height, const PixelBox& plot, const IsFree& is_free) {
  for (const double distance : {9.0, 20.0, 34.0}) {
    const double left = at.x - width - distance, right = at.x + distance, middle = at.x - width / 2;
    const double level = at.y - height / 2, above = at.y - distance - height, below = at.y + distance;
    for (const dvec2 corner : {dvec2(right, above), dvec2(right, level), dvec2(left, below), dvec2(left, level),
                               dvec2(right, below), dvec2(left, above), dvec2(middle, above), dvec2(middle, below)})
      if (const PixelBox box{corner.x, corner.y, width, height}; box.inside(plot) && is_free(box)) return box;
  }
  return std::nullopt;
}

bool meets(const std::vector<PixelBox>& others, const PixelBox& box) {
  return std::ranges::any_of(others, [&](const PixelBox& other) { return other.overlaps(box); });
}

}  // namespace

std::string px(double value) {
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);  // there are many of these
  return text == "-0" ? "0" : text;
}

std::string polyline(std::span<const dvec2> points) {
  std::string d;
  for (const dvec2& point : points) d += fmt::format("{}{} {}", d.empty() ? 'M' : 'L', px(point.x), px(point.y));
  return d;
}

double text_width(std::string_view text, double size) { return 0.56 * size * static_cast<double>(display_width(text)); }

std::string marker_path(std::size_t marker, dvec2 at, double r) {
  // Corners in units of the radius, x and y in turn.
  static const std::vector<double> outlines[chart_markers] = {
      {},  // a circle
      {-0.9, -0.9, 0.9, -0.9, 0.9, 0.9, -0.9, 0.9},
      {0, -1.2, 1.1, 0.8, -1.1, 0.8},
      {0, -1.3, 1.1, 0, 0, 1.3, -1.1, 0},
      {0, 1.2, 1.1, -0.8, -1.1, -0.8},
      {-0.4, -1.2, 0.4,  -1.2, 0.4,  -0.4, 1.2,  -0.4, 1.2,  0.4,  0.4,  0.4,
       0.4,  1.2,  -0.4, 1.2,  -0.4, 0.4,  -1.2, 0.4,  -1.2, -0.4, -0.4, -0.4},
      {-1.1, -0.6, -0.6, -1.1, 0, -0.5, 0.6,  -1.1, 1.1,  -0.6, 0.5,  0,
       1.1,  0.6,  0.6,  1.1,  0, 0.5,  -0.6, 1.1,  -1.1, 0.6,  -0.5, 0},
      {-1, -1, 1, -1, -1, 1, 1, 1}};
  const std::vector<double>& outline = outlines[marker % chart_markers];
  if (outline.empty())
    return fmt::format("M{} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0z", px(at.x - r), px(at.y), fmt::arg("r", px(r)),
                       fmt::arg("d", px(2 * r)));
  std::vector<dvec2> corners;
  for (std::size_t i = 0; i < outline.size(); i += 2) corners.push_back(at + r * dvec2(outline[i], outline[i + 1]));
  return polyline(corners) + "z";
}

std::string series_classes(const ChartSeries& series) {
  constexpr const char* draws[] = {"", " dots", " faint", " stairs", " guide", " context"};
  return fmt::format("series c{} d{}{}", series.colour % chart_colours, series.dash % chart_dashes,
                     draws[static_cast<std::size_t>(series.draw)]);
}

Interval natural_x_range(const Chart& chart) {
  std::vector<double> values;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) values.push_back(point.x);
  return padded_range(values, chart.x.scale);
}

Interval natural_y_range(const Chart& chart) {
  if (!chart.rows.empty()) return {static_cast<double>(chart.rows.size()) - 0.5, -0.5};  // the first on top
  std::vector<double> values;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) values.push_back(point.y);
  if (values.empty()) return padded_range(values, chart.y.scale);
  const auto [low, high] = std::ranges::minmax_element(values);
  const double span = *high - *low, lowest = *low - 0.3 * span, highest = *high + 0.3 * span;
  // A wide band widens the axis, but not beyond what leaves the lines readable: the interval of three seeds spans decades.
  const bool log = chart.y.scale == Scale::log;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      values.push_back(std::max(point.low, log ? point.y / 2 : lowest));
      values.push_back(std::min(point.high, log ? point.y * 2 : highest));
    }
  return padded_range(values, chart.y.scale);
}

Plot::Plot(const Chart& chart, const PixelBox& outer, bool compact)
    : chart_(chart),
      compact_(compact),
      x_(chart.x.range.value_or(natural_x_range(chart))),
      y_(chart.y.range.value_or(natural_y_range(chart))),
      y_scale_(chart.rows.empty() ? chart.y.scale : Scale::linear) {
  const double top = (chart.title.empty() ? 0 : 20) + (chart.y.title.empty() ? 10 : 26);
  box_ = {outer.left, outer.top + top, outer.width, outer.height - top - (chart.x.title.empty() ? 26 : 48)};
  if (chart.rows.empty()) y_ticks_ = fitting_ticks(y_, y_scale_, box_.height, 36);
  for (const std::string& row : chart.rows) y_ticks_.push_back({static_cast<double>(y_ticks_.size()), shortened(row, 32)});
  double widest = 0;
  for (const Tick& tick : y_ticks_) widest = std::max(widest, text_width(tick.label, font));
  // Some air: a page sets its figures larger on a narrow screen.
  const double left = 16 + widest * (compact ? 1.05 : 1.3), right = 16;
  box_.left += left;
  box_.width -= left + right;
  x_ticks_ = fitting_ticks(x_, chart.x.scale, box_.width, 70);
}

dvec2 Plot::place(double x, double y) const {
  const double fx = position(x, x_, chart_.x.scale), fy = position(y, y_, y_scale_);
  return {box_.left + box_.width * std::clamp(fx, -10.0, 11.0), box_.bottom() - box_.height * std::clamp(fy, 0.0, 10.0)};
}

std::string Plot::axes() const {
  std::string grid, labels;
  for (const Tick& tick : x_ticks_) {
    const double x = place(tick.value, y_.low).x;
    grid += fmt::format(R"(<path class="{}" d="M{} {}V{}"/>)", tick.label.empty() ? "minor" : "grid", px(x), px(box_.top),
                        px(box_.bottom()));
    if (!tick.label.empty()) labels += text_at(x, box_.bottom() + 18, "middle", "", tick.label);
  }
  for (const Tick& tick : y_ticks_) {
    const double y = place(x_.low, tick.value).y;
    const bool zero = chart_.rows.empty() && y_scale_ == Scale::linear && tick.value == 0;
    const char* classes = zero ? "zero" : tick.label.empty() ? "minor" : "grid";
    grid += fmt::format(R"(<path class="{}" d="M{} {}H{}"/>)", classes, px(box_.left), px(y), px(box_.right()));
    if (!tick.label.empty()) labels += text_at(box_.left - 8, y + 4.5, "end", "", tick.label);
  }
  std::string out = fmt::format(R"(<g class="axes">{}<rect class="frame" x="{}" y="{}" width="{}" height="{}"/>)", grid,
                                px(box_.left), px(box_.top), px(box_.width), px(box_.height));
  out += labels + text_at(box_.left + box_.width / 2, box_.bottom() + 40, "middle", "axis-title", chart_.x.title);
  if (!chart_.y.title.empty()) out += text_at(box_.left, box_.top - 9, "start", "axis-title", chart_.y.title);
  return out + "</g>\n";
}

std::string Plot::line_path(const ChartSeries& series) const {
  const auto points = mapped(series.points, [&](const ChartPoint& point) { return place(point.x, point.y); });
  if (series.draw != Draw::stairs) return polyline(points);
  std::string d = polyline({points.data(), 1});
  for (std::size_t i = 1; i < points.size(); ++i) d += fmt::format("H{}V{}", px(points[i].x), px(points[i].y));
  return d + "H" + px(box_.right());
}

std::string Plot::band_path(const ChartSeries& series) const {
  const std::vector<ChartPoint>& points = series.points;
  if (std::ranges::none_of(points, [](const ChartPoint& p) { return p.high > p.low; })) return {};
  if (points.size() == 1) {  // no width to fill: a bar
    const dvec2 high = place(points[0].x, points[0].high), low = place(points[0].x, points[0].low);
    return fmt::format("M{} {}h6V{}h-6z", px(high.x - 3), px(std::max(high.y, box_.top)), px(std::max(low.y, box_.top)));
  }
  auto outline = mapped(points, [&](const ChartPoint& point) { return place(point.x, point.high); });
  for (auto point = points.rbegin(); point != points.rend(); ++point) outline.push_back(place(point->x, point->low));
  outline = part_below(outline, box_.top);  // marks alone may lie across the frame
  return outline.empty() ? "" : polyline(outline) + "Z";
}

// Markers on at most about twenty points of a line: more run into each other.
std::string Plot::markers(const ChartSeries& series) const {
  const double radius = series.draw == Draw::faint ? 2.6 : series.draw == Draw::dots ? 5 : compact_ ? 3.2 : 4;
  const std::size_t stride = series.draw == Draw::line ? (series.points.size() + 19) / 20 : 1;
  std::string marks, zeros;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const ChartPoint& point = series.points[i];
    const dvec2 at = place(point.x, point.y);
    if (y_scale_ == Scale::log && point.y <= 0)
      zeros += fmt::format("M{} {}h12l-6 8z", px(at.x - 6), px(at.y - 9));
    else if ((series.points.size() - 1 - i) % stride == 0)
      marks += marker_path(series.marker, at, radius);
  }
  std::string out;
  if (!marks.empty()) out += fmt::format(R"(<path class="mark" d="{}"/>)", marks);
  if (!zeros.empty()) out += fmt::format(R"(<path class="mark open" d="{}"/>)", zeros);
  return out;
}

// Place, x, y and band in data, for the page's read-outs: "px,py,x,y,low,high;...", the band left out where there is none.
std::string Plot::point_data(const ChartSeries& series) const {
  std::string data;
  for (const ChartPoint& point : series.points) {
    const dvec2 at = place(point.x, point.y);
    if (at.y < box_.top) continue;  // cut off, so not to be pointed at
    data += fmt::format("{}{},{},{:.6g},{:.4g}", data.empty() ? "" : ";", px(at.x), px(at.y), point.x, point.y);
    if (point.high > point.low) data += fmt::format(",{:.3g},{:.3g}", point.low, point.high);
  }
  return data;
}

std::string Plot::draw(const ChartSeries& series) const {
  if (series.points.empty()) return {};
  if (series.draw == Draw::context) return fmt::format("<path class=\"line context\" d=\"{}\"/>\n", line_path(series));
  std::string out =
      fmt::format(R"(<g class="{}" data-key="{}" data-label="{}" data-p="{}">)", series_classes(series),
                  escape_html(series.key), escape_html(series.label + (series.detail.empty() ? "" : " " + series.detail)),
                  series.draw == Draw::guide ? "" : point_data(series));
  if (series.draw == Draw::line)
    if (const std::string band = band_path(series); !band.empty()) out += fmt::format(R"(<path class="band" d="{}"/>)", band);
  const bool line = (series.draw == Draw::line || series.draw == Draw::guide) && series.points.size() > 1;
  if (line || series.draw == Draw::stairs) out += fmt::format(R"(<path class="line" d="{}"/>)", line_path(series));
  if (series.has_marks()) out += markers(series);
  return out + "</g>\n";
}

bool Surroundings::misleads(const PixelBox& box, dvec2 at) const {
  const auto own = std::ranges::find_if(marks, [&](const Mark& mark) { return glm::distance(mark.at, at) < 0.5; });
  return own != marks.end() && std::ranges::any_of(marks, [&](const Mark& mark) {
           return mark.key != own->key && box.distance(mark.at) < box.distance(at);
         });
}

Surroundings Plot::surroundings() const {
  Surroundings around;
  for (const ChartSeries& series : chart_.series) {
    dvec2 last{0};
    for (const ChartPoint& point : series.points) {
      const dvec2 at = place(point.x, point.y);
      if (series.has_marks()) {
        around.taken.push_back({at.x - 4, at.y - 4, 8, 8});
        around.marks.push_back({at, series.key});
      }
      if (series.draw == Draw::stairs && &point != &series.points.front()) {
        around.lines.push_back({std::min(last.x, at.x), last.y - 2, std::abs(at.x - last.x), 4});
        around.lines.push_back({at.x - 2, std::min(last.y, at.y), 4, std::abs(at.y - last.y)});
      }
      last = at;
    }
  }
  return around;
}

// Labels beside their points, each where it meets neither a mark nor another label. If possible it is nearer to its own mark
// than to another's, else a thin line leads to it, and it meets no line of stairs. One that finds no room is left to the
// legend.
std::string Plot::labels() const {
  Surroundings around = surroundings();
  std::string out;
  for (const ChartLabel& label : chart_.labels) {
    const dvec2 at = place(label.x, label.y);
    if (at.y < box_.top) continue;
    const std::string text = shortened(label.text, 64);
    const double width = text_width(text, small_font), height = small_font + 2;
    std::optional<PixelBox> chosen;
    for (const auto& [misleads, crosses] : {std::pair(false, false), {false, true}, {true, false}, {true, true}}) {
      const auto is_free = [&](const PixelBox& box) {
        return !meets(around.taken, box) && (crosses || !meets(around.lines, box)) && (misleads || !around.misleads(box, at));
      };
      if (!chosen) chosen = label_place(at, width, height, box_, is_free);
    }
    if (!chosen) continue;
    around.taken.push_back(*chosen);
    if (chosen->distance(at) > 14 || around.misleads(*chosen, at))
      out += fmt::format(R"(<path class="leader" d="{}"/>)", polyline(std::array{at, chosen->nearest(at)}));
    out += text_at(chosen->left, chosen->bottom() - 3.5, "", "label", text);
  }
  return out;
}

std::string Plot::svg() const {
  std::string out;
  if (!chart_.title.empty())
    out +=
        text_at(box_.left, box_.top - (chart_.y.title.empty() ? 10 : 30), "start", "panel-title", shortened(chart_.title, 44));
  // A nested svg clips without an id, which would have to be unique in the page. A little larger: markers on the edge stay
  // whole, unless the axis was cut there.
  const double above = is_cut() ? 0 : 6;
  out += axes() +
         fmt::format("<svg class=\"plot\" x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{3}\" viewBox=\"{0} {1} {2} {3}\">\n",
                     px(box_.left - 6), px(box_.top - above), px(box_.width + 12), px(box_.height + above));
  for (const bool behind : {true, false})
    for (const ChartSeries& series : chart_.series)
      if ((series.draw == Draw::context || series.draw == Draw::faint) == behind) out += draw(series);
  return out + labels() + "</svg>\n";
}

}  // namespace etendue
