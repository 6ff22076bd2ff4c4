#include "experiments/report/rates.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace etendue {
namespace {

constexpr std::size_t enough_seeds = 10;
constexpr double wide = 0.5;  // an interval wider than that share of the exponent says little

// The exponent that theory expects; of an interval, its steep end.
double theory_of(const FittedRate& rate) { return rate.law->expected->low; }

bool is_wide(const FittedRate& rate) {
  const auto& interval = rate.fit->exponent_interval;
  return interval && interval->high - interval->low > wide * std::max(std::abs(theory_of(rate)), 0.1);
}

JudgedPrediction judged(const FittedRate& rate) {
  const Prediction& law = *rate.law;
  JudgedPrediction row{.scene = rate.scene,
                       .region = law.region,
                       .method = rate.method,
                       .quantity = fmt::format("exponent of {} over {}", law.metric, law.x),
                       .source = law.source,
                       .kind = FigureKind::exponent,
                       .expected = law.expected,
                       .problem = rate.problem};
  row.details = {{"points_are", law.across ? "configurations" : "checkpoints"}, {"seeds", rate.seeds}};
  if (!rate.fit) return row;
  const RateFit& fit = *rate.fit;
  row.measure(fit.exponent, fit.exponent_interval);
  row.marks = fmt::format("{}{}", rate.seeds < enough_seeds ? " †" : "", is_wide(rate) ? " ‡" : "");
  // Points that noise left above zero tell nothing of those below.
  if ((fit.dropped > 0 || rate.holds_noise) && row.verdict) row.verdict = Verdict::undecided;
  row.details.emplace_back("points", fit.dropped == 0
                                         ? TableCell(fit.points)
                                         : TableCell(static_cast<double>(fit.points),
                                                     fmt::format("{} of {}", fit.points, fit.points + fit.dropped)));
  row.details.emplace_back("window",
                           TableCell::ordered(fmt::format("{}–{}", format_short(fit.from), format_short(fit.to)), fit.from));
  row.details.emplace_back("from", TableCell(fit.from));
  row.details.emplace_back("to", TableCell(fit.to));
  if (law.model == Prediction::Model::plateau) row.add_detail("plateau", fit.plateau, fit.plateau_interval);
  return row;
}

// Holds what the laws of one chart share.
struct ChartKey {
  std::string scene, region, metric, x;
  auto operator<=>(const ChartKey&) const = default;
};
ChartKey key_of(const FittedRate& rate) { return {rate.scene, rate.law->region, rate.law->metric, rate.law->x}; }

ChartSeries fit_line(const FittedRate& rate, const ChartSeries& series) {
  constexpr int steps = 24;
  ChartSeries line = series;
  line.draw = ChartSeries::Draw::guide;
  line.points.clear();
  const RateFit& fit = *rate.fit;
  for (int i = 0; i <= steps; ++i) {
    const double x = fit.from * std::pow(fit.to / fit.from, i / static_cast<double>(steps)), y = fit.value(x);
    line.points.push_back({x, y, y, y});
  }
  return line;
}

// A right triangle on logarithmic axes: from (x0, y0) along its hypotenuse to (x1, y1).
struct SlopeTriangle {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;

  bool overlaps(const SlopeTriangle& other) const {
    constexpr double apart = 1.2;  // their labels lie below
    return x0 < other.x1 && other.x0 < x1 && std::min(y0, y1) < apart * std::max(other.y0, other.y1) &&
           std::min(other.y0, other.y1) < apart * std::max(y0, y1);
  }
};

// Below the middle of the fit, its hypotenuse of theory's slope; the `depth`-th of several that lie below each other.
SlopeTriangle slope_triangle(const FittedRate& rate, int depth) {
  const RateFit& fit = *rate.fit;
  const double span = std::log(fit.to / fit.from), e = theory_of(rate);
  // Where a plateau takes over, the decay is seen at the beginning.
  const double middle = rate.law->model == Prediction::Model::plateau ? 0.2 : 0.5;
  const double half = std::max(0.12 * span, 0.35), x0 = fit.from * std::exp(middle * span - half), x1 = x0 * std::exp(2 * half);
  const double y0 = std::pow(0.62, depth) * std::min(fit.value(x0), fit.value(x1) * std::pow(x0 / x1, e));
  return {x0, x1, y0, y0 * std::pow(x1 / x0, e)};
}

void add_triangle(Chart& chart, const FittedRate& rate, std::vector<SlopeTriangle>& drawn) {
  constexpr int deepest = 5;
  int depth = 1;
  const auto overlaps = [&](const SlopeTriangle& other) { return slope_triangle(rate, depth).overlaps(other); };
  while (depth < deepest && std::ranges::any_of(drawn, overlaps)) ++depth;
  const auto [x0, x1, y0, y1] = drawn.emplace_back(slope_triangle(rate, depth));
  ChartSeries triangle;
  triangle.draw = ChartSeries::Draw::context;
  for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y1}, {x0, y1}, {x0, y0}}) triangle.points.push_back({x, y, y, y});
  chart.series.push_back(std::move(triangle));
  chart.labels.push_back({std::sqrt(x0 * x1), y1, "theory " + judged(rate).expected_text()});
}

Figure rate_figure(const ChartKey& key, const std::vector<const FittedRate*>& rates) {
  const std::string where = key.region.empty() ? "whole image" : key.region;
  Figure figure{fmt::format("rate-{}-{}-{}-{}", slug(key.scene), slug(where), key.metric, slug(key.x)),
                key.scene,
                fmt::format("{}: {} over {}", where, key.metric, key.x),
                {},
                {}};
  Chart chart;
  chart.x = {key.x == "time" ? "time [s], preparation included" : key.x, Scale::log, std::nullopt};
  chart.y = {key.metric, Scale::log, std::nullopt};
  std::set<std::string> drawn, slopes;
  std::vector<SlopeTriangle> triangles;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const FittedRate* rate : rates) {
    ChartSeries series;
    series.key = series.label = rate->method;
    const std::size_t i = drawn.contains(rate->method) ? 0 : drawn.size();
    series.colour = i % chart_colours;
    series.dash = 0;
    series.marker = i % chart_markers;
    if (drawn.insert(rate->method).second) {
      for (const RatePoint& point : rate->points) {
        const RateValue value = rate_estimate(point, key.metric);
        if (value.x > 0 && value.y > 0) series.points.push_back({value.x, value.y, value.interval.low, value.interval.high});
      }
      if (series.points.empty()) continue;
      chart.series.push_back(series);
      fewest = std::min(fewest, rate->seeds);
    }
    if (!rate->fit) continue;
    for (const ChartSeries& other : chart.series)
      if (other.key == rate->method && other.draw == ChartSeries::Draw::line) series.colour = other.colour;
    chart.series.push_back(fit_line(*rate, series));
    JudgedPrediction exponent = judged(*rate);
    exponent.marks.clear();
    const std::string theory = exponent.expected_text();
    if (slopes.insert(theory).second) add_triangle(chart, *rate, triangles);
    const bool plateau = rate->law->model == Prediction::Model::plateau;
    figure.notes.push_back(
        fmt::format("{}: fitted exponent {}, theory {}{}.", rate->method, exponent.measured_text(), theory,
                    plateau ? fmt::format(", then a plateau at {}", format_figure(rate->fit->plateau)) : ""));
  }
  if (chart.series.empty()) return {};
  figure.panels.push_back(std::move(chart));
  figure.notes.push_back(fewest < 3
                             ? "Fewer than three seeds: no bands."
                             : fmt::format("Marks: over {} seeds or more; bands: 95 % by the jackknife. Thin lines: fits over "
                                           "their windows.",
                                           fewest));
  return figure;
}

}  // namespace

Predictions exponent_predictions(const std::vector<FittedRate>& rates) {
  Predictions predictions;
  for (const FittedRate& rate : rates) predictions.rows.push_back(judged(rate));
  if (rates.empty()) return predictions;
  predictions.notes.push_back(
      "Exponents: weighted least squares in logarithms through the means over seeds, within the window; the interval is a 95 % "
      "bootstrap over seeds, each a whole trajectory, since the checkpoints of one run are autocorrelated.");
  if (std::ranges::any_of(rates, [](const FittedRate& rate) { return rate.fit && rate.fit->dropped > 0; }))
    predictions.notes.push_back(
        "Of points in the window that are not above zero there is no logarithm: a fit to the others is too flat, and "
        "undecided.");
  if (std::ranges::any_of(rates, &FittedRate::holds_noise))
    predictions.notes.emplace_back(
        "The noise of references is left in where nobody knows it: in regions, and of images that were given. An exponent "
        "there is too flat where that noise is not small, and undecided.");
  const auto intervals =
      std::ranges::count_if(rates, [](const FittedRate& rate) { return rate.fit && rate.fit->exponent_interval; });
  predictions.notes.push_back(
      fmt::format("{} † fewer than ten seeds. ‡ the interval is wider than half of theory's exponent, and says little.",
                  intervals < 2 ? "An interval of 95 % misses the truth by chance once in twenty."
                                : fmt::format("Of {} intervals of 95 %, about {:.1f} miss the truth by chance.", intervals,
                                              0.05 * static_cast<double>(intervals))));
  return predictions;
}

std::vector<Figure> rate_figures(const std::vector<FittedRate>& rates) {
  std::vector<ChartKey> keys;
  for (const FittedRate& rate : rates)
    if (!contains(keys, key_of(rate))) keys.push_back(key_of(rate));
  std::vector<Figure> figures;
  for (const ChartKey& key : keys) {
    std::vector<const FittedRate*> shared;
    for (const FittedRate& rate : rates)
      if (key_of(rate) == key) shared.push_back(&rate);
    if (Figure figure = rate_figure(key, shared); !figure.empty()) figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace etendue
