#include "experiments/report/charts/charts.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace etendue {
namespace {

constexpr std::size_t most_series_in_a_panel = 10, most_context_series = 40;

// A scene's configurations spread over one panel, or over one for each group.
struct Panels {
  std::vector<std::vector<const Configuration*>> groups;
  std::vector<std::string> titles;
  bool by_structure = false;  // in each panel, colours distinguish structures
};

Panels arrange_panels(const ReportData& data, const SceneData& scene, Layout layout) {
  const std::vector<const Configuration*> all = scene.finished();
  if (all.empty()) return {};
  const bool by_structure = data.accels.size() > 1;
  std::vector<std::string> titles;
  std::map<std::string, std::vector<const Configuration*>> groups;
  for (const Configuration* configuration : all) {
    const std::string& name = configuration->integrator;
    const std::string group = by_structure ? configuration->short_integrator : name.substr(0, name.find(' '));
    index_in(titles, group);
    groups[group].push_back(configuration);
  }
  if (layout == Layout::overlay || all.size() <= most_series_in_a_panel || groups.size() < 2 || groups.size() == all.size())
    return {{all}, {""}, data.integrators.size() == 1 && by_structure};
  Panels panels{{}, titles, by_structure};
  for (const std::string& title : titles) panels.groups.push_back(groups[title]);
  return panels;
}

ChartSeries styled(const ReportData& data, const Panels& panels, const Configuration& configuration) {
  const std::size_t i = configuration.integrator_index, a = configuration.accel_index;
  ChartSeries series;
  series.key = fmt::format("i{}a{}", i, a);
  series.label = short_label(data, configuration);
  const bool several = panels.groups.size() > 1;
  series.style(panels.by_structure ? a : i);
  if (panels.by_structure && several) {  // switched together in all panels, whose titles name the integrators
    series.key = fmt::format("a{}", a);
    series.label = configuration.short_accel;
  } else if (!panels.by_structure && !several && data.accels.size() > 1) {
    series.dash = a % chart_dashes;
    series.marker = a % chart_markers;  // colour says the integrator, shape the structure
  }
  return series;
}

// Gives points over all seeds, with their bands.
std::vector<ChartPoint> points_of(const Configuration& configuration, const std::string& metric, Abscissa abscissa,
                                  bool with_sign) {
  return mapped(aggregate(configuration, metric, abscissa, with_sign), [](const SeriesPoint& point) {
    return ChartPoint(point.x, point.y.centre, point.y.interval.low, point.y.interval.high);
  });
}

std::string axis_title(Abscissa abscissa) {
  return abscissa == Abscissa::time ? "time [s], preparation included" : "iterations";
}

std::string spread_note(const SceneData& scene, bool with_sign) {
  std::size_t fewest = std::numeric_limits<std::size_t>::max(), most = 0;
  for (const Configuration* configuration : scene.finished()) {
    fewest = std::min(fewest, configuration->replicates.size());
    most = std::max(most, configuration->replicates.size());
  }
  if (most == 1) return "One seed: no band can be drawn.";
  const char* band = fewest >= 3 ? "its 95 % Student interval"
                     : most <= 2 ? "both extremes"
                                 : "its 95 % Student interval from three seeds on, else the extremes";
  return fmt::format("Lines: {} over {} seeds; bands: {}.", with_sign ? "mean" : "geometric mean",
                     fewest == most ? fmt::format("{}", most) : fmt::format("{} to {}", fewest, most), band);
}

// Structures that change only the time give equal curves over iterations.
std::string coincidence_note(const ReportData& data, const SceneData& scene, const std::string& metric) {
  if (data.accels.size() < 2) return {};
  // Errors are kept by integrator, seed and iterations.
  std::map<std::tuple<std::size_t, std::uint64_t, std::uint64_t>, std::vector<double>> errors;
  for (const Configuration& configuration : scene.configurations)
    for (const Replicate& replicate : configuration.replicates)
      for (const CheckpointRecord* checkpoint : replicate.checkpoints)
        if (const auto error = find_value(checkpoint->metrics, metric))
          errors[{configuration.integrator_index, replicate.seed, checkpoint->iterations}].push_back(*error);
  std::size_t shared = 0, equal = 0;
  for (const auto& [key, values] : errors) {
    if (values.size() < 2) continue;
    ++shared;
    equal += std::ranges::all_of(values, [&](double value) { return value == values.front(); });
  }
  if (shared == 0) return {};
  if (equal == shared)
    return fmt::format("At all {} checkpoints that structures share their errors are equal to the last bit.", shared);
  return fmt::format("At {} of the {} checkpoints that structures share their errors differ.", shared - equal, shared);
}

// Says once what all names leave out.
void add_left_out(const ReportData& data, std::vector<std::string>& notes) {
  if (!data.left_out_of_names.empty())
    notes.push_back(fmt::format("Left out of names: {}.", fmt::join(data.left_out_of_names, "; ")));
}

void add_reference_floor(Chart& chart, const SceneData& scene, const std::string& metric) {
  if (metric != "mse" || scene.reference == nullptr || scene.reference->mse_floor <= 0) return;
  const Interval x = natural_x_range(chart), y = natural_y_range(chart);
  const double floor = scene.reference->mse_floor;
  if (chart.y.scale == Scale::log && floor < y.low / 30) return;
  chart.x.range = x;
  ChartSeries line;
  line.draw = ChartSeries::Draw::context;
  line.points = {{x.low, floor}, {x.high, floor}};
  chart.series.push_back(line);
  chart.labels.push_back({chart.x.scale == Scale::log ? x.low * 1.05 : x.low, floor, "reference's own variance"});
}

// Adds what others measured of this scene: markers alone, since nobody saw how it got there.
void add_elsewhere(Chart& chart, const ReportData& data, const SceneData& scene, const std::string& metric) {
  std::vector<std::string> names;  // of all scenes: one looks the same in each
  for (const ElsewhereFigure& figure : data.log->stated.elsewhere) {
    const std::string name = fmt::format("elsewhere: {}, {}", figure.program, figure.method);
    const std::size_t style = data.integrators.size() * data.accels.size() + index_in(names, name);
    if (!figure.of_scene(scene.name) || figure.metric != metric) continue;
    ChartSeries& mark = chart.series.emplace_back();
    mark.key = mark.label = name;
    mark.detail = fmt::format("{}, {}", figure.machine, figure.date);
    mark.draw = ChartSeries::Draw::dots;
    mark.style(style);
    mark.points = {{figure.time_s, figure.error}};
  }
}

// On a linear axis the first checkpoints would press all that follows against zero: it ends at a few times the last errors.
void cut_linear_axis(Chart& chart, std::vector<std::string>& notes) {
  constexpr double times = 6;
  if (chart.y.scale != Scale::linear) return;
  std::map<std::string, ChartPoint> last_points;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points)
      if (series.draw != ChartSeries::Draw::stairs && series.draw != ChartSeries::Draw::context)
        if (ChartPoint& latest = last_points[series.key]; point.x >= latest.x) latest = point;
  double last = 0;
  for (const auto& [key, point] : last_points) last = std::max(last, point.y);
  const Interval natural = natural_y_range(chart);
  if (last <= 0 || natural.low < 0 || natural.high <= times * last) return;
  chart.y.range = {0, times * last};
  const std::string note = "The linear axis ends at six times the largest last error.";
  if (!contains(notes, note)) notes.push_back(note);
}

void share_ranges(std::vector<Chart>& panels) {
  if (panels.size() < 2) return;
  const auto share = [&](Axis Chart::*axis, Interval (*natural)(const Chart&)) {
    Interval range = (panels[0].*axis).range.value_or(natural(panels[0]));
    for (const Chart& chart : panels) {
      const Interval own = (chart.*axis).range.value_or(natural(chart));
      range = {std::min(range.low, own.low), std::max(range.high, own.high)};
    }
    for (Chart& chart : panels) (chart.*axis).range = range;
  };
  share(&Chart::x, natural_x_range);
  share(&Chart::y, natural_y_range);
}

}  // namespace

Figure error_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Abscissa abscissa, Scale scale,
                    Layout layout) {
  const bool over_time = abscissa == Abscissa::time, with_sign = data.is_signed(metric);
  const char* over = over_time ? "time" : "iterations";
  Figure figure{.name = fmt::format("error-{}-{}-{}", over, scene.file_stem, slug(metric)),
                .scene = scene.name,
                .title = fmt::format("{} over {}", metric, over)};
  const Panels panels = arrange_panels(data, scene, layout);
  const bool with_others = scene.finished().size() <= most_context_series;
  bool zeros = false, any = false;
  for (std::size_t g = 0; g < panels.groups.size(); ++g) {
    Chart chart{
        .title = panels.titles[g], .x = {axis_title(abscissa), scale}, .y = {metric, with_sign ? Scale::linear : scale}};
    for (std::size_t other = 0; other < panels.groups.size() && with_others; ++other)
      for (const Configuration* configuration : panels.groups[other]) {
        if (other == g) continue;
        ChartSeries& line = chart.series.emplace_back();
        line.draw = ChartSeries::Draw::context;
        for (const ChartPoint& point : points_of(*configuration, metric, abscissa, with_sign))
          line.points.emplace_back(point.x, point.y);
      }
    for (const Configuration* member : panels.groups[g]) {
      const Configuration& configuration = *member;
      ChartSeries series = styled(data, panels, configuration);
      series.points = points_of(configuration, metric, abscissa, with_sign);
      for (const ChartPoint& point : series.points) zeros = zeros || (!with_sign && point.y <= 0);
      if (series.points.empty()) continue;
      any = true;
      chart.series.push_back(std::move(series));
    }
    if (over_time) add_elsewhere(chart, data, scene, metric);
    add_reference_floor(chart, scene, metric);
    figure.panels.push_back(std::move(chart));
  }
  if (!any) return {};
  figure.notes.push_back(spread_note(scene, with_sign));
  if (!with_sign)
    for (Chart& chart : figure.panels) cut_linear_axis(chart, figure.notes);
  share_ranges(figure.panels);
  if (zeros && scale == Scale::log) figure.notes.push_back("Open triangles on the lower edge: an error of zero.");
  if (!over_time)
    if (const std::string note = coincidence_note(data, scene, metric); !note.empty()) figure.notes.push_back(note);
  add_left_out(data, figure.notes);
  return figure;
}

ChartSeries method_series(const ReportData& data, const Configuration& configuration) {
  return styled(data, {{{}}, {""}, data.integrators.size() == 1 && data.accels.size() > 1}, configuration);
}

Figure front_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Scale scale) {
  const bool with_sign = data.is_signed(metric);
  const std::string shown = with_sign ? "|" + metric + "|" : metric;
  std::map<std::size_t, std::vector<FrontPoint>> by_configuration;
  ChartSeries front{.key = "front", .label = "front: least error by then", .draw = ChartSeries::Draw::stairs};
  for (const FrontPoint& point : front_points(scene, metric, with_sign)) {
    by_configuration[point.configuration].push_back(point);
    if (point.on_front) front.points.emplace_back(point.time_s, point.error);
  }
  if (by_configuration.size() < 2) return {};
  std::ranges::sort(front.points, [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  Chart chart{.x = {axis_title(Abscissa::time), scale}, .y = {shown, scale}, .series = {std::move(front)}};  // below the marks
  for (const auto& [c, points] : by_configuration) {
    ChartSeries pale = method_series(data, scene.configurations[c]);
    pale.dash = 0;
    ChartSeries bold = pale;
    pale.draw = ChartSeries::Draw::faint;
    bold.draw = ChartSeries::Draw::dots;
    for (const FrontPoint& point : points) (point.on_front ? bold : pale).points.emplace_back(point.time_s, point.error);
    // What has a part of the front is named amid it; the legend names the others.
    if (!bold.points.empty()) {
      const ChartPoint& middle = bold.points[bold.points.size() / 2];
      chart.labels.push_back({middle.x, middle.y, short_label(data, scene.configurations[c])});
    }
    chart.series.push_back(std::move(bold));
    chart.series.push_back(std::move(pale));
  }
  std::vector<std::string> notes{"Each mark is a checkpoint, averaged over seeds; marks on the front are bold."};
  cut_linear_axis(chart, notes);
  add_left_out(data, notes);
  return {fmt::format("front-{}-{}", scene.file_stem, slug(metric)),
          scene.name,
          fmt::format("{} against time, and what nothing beats", shown),
          {std::move(chart)},
          notes};
}

std::vector<Figure> file_figures(const ReportData& data) {
  std::vector<Figure> figures;
  const auto add = [&](Figure figure) {
    if (!figure.empty()) figures.push_back(std::move(figure));
  };
  for (const SceneData& scene : data.scenes) {
    for (const std::string& metric : data.metrics) {
      add(error_figure(data, scene, metric, Abscissa::time, Scale::log));
      add(error_figure(data, scene, metric, Abscissa::iterations, Scale::log));
      if (!data.is_signed(metric)) add(front_figure(data, scene, metric, Scale::log));
    }
  }
  return figures;
}

std::string to_svg(const Figure& figure) {
  if (!figure.drawing.svg.empty()) return standalone_svg(figure.title, figure.drawing, figure.notes);
  const std::string of = figure.scene.empty() ? "" : figure.scene + ": ";
  return standalone_svg(of + figure.title, figure.panels, figure.notes);
}

}  // namespace etendue
