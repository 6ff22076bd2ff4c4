#include "experiments/report/charts.h"

#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace etendue {
namespace {

constexpr std::size_t most_series_in_a_panel = 10, most_context_series = 40;

// How a scene's configurations spread over panels: one panel, or one for each group.
struct Panels {
  std::vector<std::vector<const Configuration*>> groups;
  std::vector<std::string> titles;
  bool by_structure = false;  // in each panel, colours distinguish structures
};

Panels arrange_panels(const ReportData& data, const SceneData& scene) {
  std::vector<const Configuration*> all;
  for (const Configuration& configuration : scene.configurations)
    if (!configuration.replicates.empty()) all.push_back(&configuration);
  if (all.empty()) return {};
  std::vector<std::string> order;
  std::map<std::string, std::vector<const Configuration*>> groups;
  for (const Configuration* configuration : all) {
    const std::string& name = configuration->integrator;
    const std::string group = data.accels.size() > 1 ? name : name.substr(0, name.find(' '));
    if (!groups.contains(group)) order.push_back(group);
    groups[group].push_back(configuration);
  }
  if (all.size() <= most_series_in_a_panel || groups.size() < 2 || groups.size() == all.size())
    return {{all}, {""}, data.integrators.size() == 1 && data.accels.size() > 1};
  Panels panels{{}, order, data.accels.size() > 1};
  for (const std::string& group : order) panels.groups.push_back(groups[group]);
  return panels;
}

ChartSeries styled(const ReportData& data, const Panels& panels, const Configuration& configuration, std::size_t within) {
  ChartSeries series;
  series.key = fmt::format("i{}a{}", configuration.integrator_index, configuration.accel_index);
  series.label = label(data, configuration);
  const std::size_t i = configuration.integrator_index, a = configuration.accel_index;
  const auto cycle = [&](std::size_t index) {
    series.colour = index % chart_colours;
    series.dash = index / chart_colours % chart_dashes;
    series.marker = (index + index / chart_colours) % chart_markers;
  };
  if (panels.by_structure) {
    cycle(a);
    if (panels.groups.size() > 1) {  // switched together in all panels, whose titles name the integrators
      series.key = fmt::format("a{}", a);
      series.label = configuration.accel;
    }
  } else if (panels.groups.size() > 1) {
    cycle(within);
  } else {
    cycle(i);
    if (data.accels.size() > 1) {
      series.dash = a % chart_dashes;
      series.marker = a % chart_markers;  // colour says the integrator, shape the structure
    }
  }
  return series;
}

std::vector<ChartPoint> to_points(const std::vector<SeriesPoint>& points) {
  std::vector<ChartPoint> result;
  for (const SeriesPoint& point : points)
    result.push_back({point.x, point.y.centre, point.y.interval.low, point.y.interval.high});
  return result;
}

std::string axis_title(Abscissa abscissa) {
  return abscissa == Abscissa::time ? "time [s], preparation included" : "iterations";
}

std::string spread_note(const SceneData& scene, bool with_sign) {
  std::size_t fewest = std::numeric_limits<std::size_t>::max(), most = 0;
  for (const Configuration& configuration : scene.configurations) {
    if (configuration.replicates.empty()) continue;
    fewest = std::min(fewest, configuration.replicates.size());
    most = std::max(most, configuration.replicates.size());
  }
  const char* centre = with_sign ? "mean" : "geometric mean";
  if (most == 1) return "One seed: no band can be drawn.";
  const std::string seeds = fewest == most ? fmt::format("{}", most) : fmt::format("{} to {}", fewest, most);
  const char* band = fewest >= 3 ? "its 95 % Student interval"
                     : most <= 2 ? "both extremes"
                                 : "its 95 % Student interval from three seeds on, else the extremes";
  return fmt::format("Lines: {} over {} seeds; bands: {}.", centre, seeds, band);
}

// Structures that change only the time give equal curves over iterations.
std::string coincidence_note(const ReportData& data, const SceneData& scene, const std::string& metric) {
  if (data.accels.size() < 2) return {};
  std::map<std::tuple<std::size_t, std::uint64_t, std::uint64_t>, std::set<double>> values;
  std::map<std::tuple<std::size_t, std::uint64_t, std::uint64_t>, int> structures;
  for (const Configuration& configuration : scene.configurations)
    for (const Replicate& replicate : configuration.replicates)
      for (const CheckpointRecord* checkpoint : replicate.checkpoints)
        if (const auto found = checkpoint->metrics.find(metric); found != checkpoint->metrics.end()) {
          const std::tuple key{configuration.integrator_index, replicate.seed, checkpoint->iterations};
          values[key].insert(found->second);
          ++structures[key];
        }
  std::size_t shared = 0, equal = 0;
  for (const auto& [key, count] : structures) {
    if (count < 2) continue;
    ++shared;
    equal += values[key].size() == 1;
  }
  if (shared == 0) return {};
  if (equal == shared)
    return fmt::format("At all {} checkpoints that structures share their errors are equal to the last bit.", shared);
  return fmt::format("At {} of the {} checkpoints that structures share their errors differ.", shared - equal, shared);
}

void add_reference_floor(Chart& chart, const SceneData& scene, const std::string& metric) {
  if (metric != "mse" || scene.reference == nullptr || scene.reference->mse_floor <= 0) return;
  const Interval x = natural_x_range(chart), y = natural_y_range(chart);
  const double floor = scene.reference->mse_floor;
  if (chart.y.scale == Scale::log && floor < y.low / 30) return;
  chart.x.range = x;
  ChartSeries line;
  line.draw = ChartSeries::Draw::context;
  line.points = {{x.low, floor, floor, floor}, {x.high, floor, floor, floor}};
  chart.series.push_back(line);
  chart.labels.push_back({chart.x.scale == Scale::log ? x.low * 1.05 : x.low, floor, "reference's own variance"});
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
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

void share_ranges(std::vector<Chart>& panels) {
  if (panels.size() < 2) return;
  const auto x_of = [](const Chart& chart) { return chart.x.range.value_or(natural_x_range(chart)); };
  const auto y_of = [](const Chart& chart) { return chart.y.range.value_or(natural_y_range(chart)); };
  Interval x = x_of(panels[0]), y = y_of(panels[0]);
  for (const Chart& chart : panels) {
    const Interval cx = x_of(chart), cy = y_of(chart);
    x = {std::min(x.low, cx.low), std::max(x.high, cx.high)};
    y = {std::min(y.low, cy.low), std::max(y.high, cy.high)};
  }
  for (Chart& chart : panels) {
    chart.x.range = x;
    chart.y.range = y;
  }
}

}  // namespace

Figure error_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Abscissa abscissa, Scale scale) {
  const bool over_time = abscissa == Abscissa::time, with_sign = data.is_signed(metric);
  Figure figure{fmt::format("error-{}-{}-{}", over_time ? "time" : "iterations", scene.file_stem, slug(metric)),
                scene.name,
                fmt::format("{} over {}", metric, over_time ? "time" : "iterations"),
                {},
                {}};
  const Panels panels = arrange_panels(data, scene);
  bool zeros = false, any = false;
  for (std::size_t g = 0; g < panels.groups.size(); ++g) {
    Chart chart;
    chart.title = panels.titles[g];
    chart.x = {axis_title(abscissa), scale, std::nullopt};
    chart.y = {metric, with_sign ? Scale::linear : scale, std::nullopt};
    std::size_t total = 0;
    for (const auto& group : panels.groups) total += group.size();
    for (std::size_t other = 0; other < panels.groups.size() && total <= most_context_series; ++other)
      for (const Configuration* configuration : panels.groups[other]) {
        if (other == g) continue;
        ChartSeries line;
        line.draw = ChartSeries::Draw::context;
        line.points = to_points(aggregate(*configuration, metric, abscissa, with_sign));
        for (ChartPoint& point : line.points) point.low = point.high = point.y;
        chart.series.push_back(std::move(line));
      }
    for (std::size_t i = 0; i < panels.groups[g].size(); ++i) {
      const Configuration& configuration = *panels.groups[g][i];
      ChartSeries series = styled(data, panels, configuration, i);
      series.points = to_points(aggregate(configuration, metric, abscissa, with_sign));
      for (const ChartPoint& point : series.points) zeros = zeros || (!with_sign && point.y <= 0);
      if (series.points.empty()) continue;
      any = true;
      chart.series.push_back(std::move(series));
    }
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
  return figure;
}

Figure front_figure(const ReportData& data, const SceneData& scene, const std::string& metric, Scale scale) {
  if (data.is_signed(metric)) return {};
  const std::vector<FrontPoint> points = front_points(scene, metric);
  std::set<std::size_t> present;
  for (const FrontPoint& point : points) present.insert(point.configuration);
  if (present.size() < 2) return {};
  Chart chart;
  chart.x = {axis_title(Abscissa::time), scale, std::nullopt};
  chart.y = {metric, scale, std::nullopt};
  // One plot whatever the number: the question is about all configurations together.
  const Panels one{{{}}, {""}, data.integrators.size() == 1 && data.accels.size() > 1};
  ChartSeries front;
  front.key = "front";
  front.label = "front: least error by then";
  front.draw = ChartSeries::Draw::stairs;
  for (const std::size_t c : present) {
    ChartSeries pale = styled(data, one, scene.configurations[c], 0);
    pale.dash = 0;
    ChartSeries bold = pale;
    pale.draw = ChartSeries::Draw::faint;
    bold.draw = ChartSeries::Draw::dots;
    for (const FrontPoint& point : points)
      if (point.configuration == c)
        (point.on_front ? bold : pale).points.push_back({point.time_s, point.error, point.error, point.error});
    chart.series.push_back(std::move(bold));
    chart.series.push_back(std::move(pale));
  }
  for (const FrontPoint& point : points)
    if (point.on_front) front.points.push_back({point.time_s, point.error, point.error, point.error});
  std::sort(front.points.begin(), front.points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  chart.series.insert(chart.series.begin(), std::move(front));  // below the marks

  // What has a part of the front is named amid it; the legend names the others.
  for (const std::size_t c : present) {
    std::vector<const FrontPoint*> on_front;
    for (const FrontPoint& point : points)
      if (point.configuration == c && point.on_front) on_front.push_back(&point);
    if (on_front.empty()) continue;
    const FrontPoint& at = *on_front[on_front.size() / 2];
    chart.labels.push_back({at.time_s, at.error, label(data, scene.configurations[c])});
  }

  std::vector<std::string> notes{"Each mark is a checkpoint, averaged over seeds; marks on the front are bold."};
  cut_linear_axis(chart, notes);
  return {fmt::format("front-{}-{}", scene.file_stem, slug(metric)),
          scene.name,
          fmt::format("{} against time, and what nothing beats", metric),
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
      add(front_figure(data, scene, metric, Scale::log));
    }
    add(structures_figure(data, scene));
    add(break_even_figure(data, scene));
    add(ray_cost_figure(data, scene));
  }
  for (Figure& figure : structure_sweep_figures(data)) add(std::move(figure));
  add(structures_over_scenes_figure(data));
  return figures;
}

std::string to_svg(const Figure& figure) {
  return standalone_svg(figure.scene + ": " + figure.title, figure.panels, figure.notes);
}

}  // namespace etendue
