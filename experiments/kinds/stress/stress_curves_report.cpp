// Curves of a hazard: the figure against its parameter, a series for each method with a band over seeds, the bound of a sound
// method, thresholds on it with their intervals, and those that theory expects.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// What has a curve looks the same in all hazards: the methods of the matrix in its order, then remedies.
std::size_t style_of(const StressMap& map, const StressCell& cell) {
  std::vector<std::string> names = cell.record->of_structure ? map.structure_columns : map.columns;
  for (const StressRow& row : map.rows)
    if (row.record().of_structure == cell.record->of_structure)
      for (const StressCell& remedy : row.remedies) index_in(names, remedy.name());
  return index_in(names, cell.name());
}

std::string x_title(const StressRecord& r) {
  return fmt::format("{}{}, harm grows to the {}", r.parameter, r.unit.empty() ? "" : " [" + r.unit + "]",
                     r.range.to > r.range.from ? "right" : "left");
}

ChartSeries curve_of(const StressMap& map, const StressCell& cell) {
  const StressRecord& r = *cell.record;
  ChartSeries series{.key = r.cell.integrator, .label = r.cell.integrator, .detail = r.method};
  series.style(style_of(map, cell));
  for (const StressPoint& point : r.points) {
    const auto [low, high] = std::ranges::minmax(point.values);
    series.points.emplace_back(point.x, mean(point.values), low, high);
  }
  std::ranges::stable_sort(series.points, {}, &ChartPoint::x);
  return series;
}

// The rounding errors of exact methods would press all others together: they lie on the lower edge. Whether there are any.
bool leave_out_rounding(Chart& chart) {
  constexpr double rounding = 1e-9;
  std::vector<double> seen;
  std::size_t all = 0;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points)
      for (const double value : {point.low, point.y, point.high}) {
        ++all;
        if (value >= rounding) seen.push_back(value);
      }
  if (seen.empty() || seen.size() == all) return false;
  chart.y.range = padded_range(seen, Scale::log);
  return true;
}

// A thin line in the series' colour, switched with it.
ChartSeries guide_of(const ChartSeries& series, std::vector<ChartPoint> points) {
  ChartSeries guide = series;
  guide.label = guide.detail = "";
  guide.draw = ChartSeries::Draw::guide;
  guide.points = std::move(points);
  return guide;
}

}  // namespace

Figure curve_figure(const StressMap& map, const StressRow& row) {
  const StressRecord& of = row.record();
  Chart chart;
  chart.x.title = x_title(of);
  chart.y.title = of.figure_text;
  bool positive = true;
  std::vector<double> levels;
  std::vector<ChartSeries> marks;
  for (const auto* cells : {&row.cells, &row.remedies})
    for (const StressCell& cell : *cells) {
      if (!cell.threshold) continue;
      ChartSeries series = curve_of(map, cell);
      for (const ChartPoint& point : series.points) {
        positive = positive && point.low > 0;
        levels.push_back(point.y);
      }
      const double bound = crossed_bound(*cell.record);
      if (cell.threshold->holding == Holding::up_to) {
        const Interval x = cell.x_interval();
        const double low = std::max(x.low, std::min(of.range.from, of.range.to)),
                     high = std::min(x.high, std::max(of.range.from, of.range.to));
        marks.push_back(guide_of(series, {{low, bound}, {high, bound}}));
        ChartSeries dot = guide_of(series, {{cell.x(), bound}});
        dot.draw = ChartSeries::Draw::dots;
        dot.label = series.label;
        marks.push_back(std::move(dot));
      }
      chart.series.push_back(std::move(series));
    }
  chart.y.scale = positive ? Scale::log : Scale::linear;
  if (levels.empty()) return {};
  for (const double bound : {of.holds.low, of.holds.high})
    if (std::isfinite(bound) && (!positive || bound > 0)) {
      chart.series.push_back(
          {.key = "bound",
           .draw = ChartSeries::Draw::context,
           .points = {{std::min(of.range.from, of.range.to), bound}, {std::max(of.range.from, of.range.to), bound}}});
      levels.push_back(bound);
    }
  const bool has_rounding = positive && leave_out_rounding(chart);
  const auto [lowest, highest] = std::ranges::minmax(levels);
  for (const auto* cells : {&row.cells, &row.remedies})
    for (const StressCell& cell : *cells) {
      if (!cell.threshold || !cell.record->is_expected) continue;
      const auto series = std::ranges::find(chart.series, cell.record->cell.integrator, &ChartSeries::key);
      for (const auto& end : {cell.record->expected_low, cell.record->expected_high})
        if (end && *end > 0 && of.range.t_of(*end) >= 0 && of.range.t_of(*end) <= 1)
          marks.push_back(guide_of(*series, {{*end, lowest}, {*end, highest}}));
    }
  chart.series.insert(chart.series.end(), std::make_move_iterator(marks.begin()), std::make_move_iterator(marks.end()));
  Figure figure{
      .name = fmt::format("{}-{}", of.cell.accel, slug(of.hazard)),
      .scene = of.hazard,
      .title = fmt::format("{} against {}", of.figure, of.parameter),
      .panels = {std::move(chart)},
      .notes = {"Means over seeds; bands are their extremes. Grey: the bound of a sound method. Marks on it: thresholds "
                "with their 95 % intervals. Dotted uprights: the interval in which theory expects a method's threshold."}};
  if (has_rounding) figure.notes.emplace_back("Marks on the lower edge: exact but for rounding.");
  return figure;
}

}  // namespace etendue
