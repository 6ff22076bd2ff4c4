#include "experiments/report/rate_report.h"

#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace etendue {
namespace {

constexpr std::size_t enough_seeds = 10;
constexpr double wide = 0.5;  // an interval wider than that share of the exponent says little

std::string signed_text(double value) { return fmt::format("{:.3f}", value); }

std::string with_interval(const RateFit& fit) {
  std::string text = signed_text(fit.exponent);
  if (fit.exponent_interval)
    text += fmt::format(" ({} to {})", signed_text(fit.exponent_interval->low), signed_text(fit.exponent_interval->high));
  return text;
}

bool is_wide(const FittedRate& rate) {
  const auto& interval = rate.fit->exponent_interval;
  return interval && interval->high - interval->low > wide * std::max(std::abs(rate.law->exponent), 0.1);
}

std::string verdict(const FittedRate& rate) {
  const auto contained = rate.contains();
  if (!contained) return "–";
  return std::string(*contained ? "yes" : "no") + (is_wide(rate) ? " ‡" : "");
}

std::string place(const FittedRate& rate) { return rate.law->region.empty() ? "whole image" : rate.law->region; }

std::string quantity(const RateLaw& law) { return law.metric + " over " + law.x; }

void add_number(std::vector<TableCell>& cells, const std::optional<double>& value) {
  cells.push_back(value ? TableCell::number(*value) : TableCell{});
}

std::vector<TableCell> table_row(const FittedRate& rate) {
  const RateLaw& law = *rate.law;
  std::vector<TableCell> cells{TableCell::words(rate.scene),
                               TableCell::words(place(rate)),
                               TableCell::words(rate.method),
                               TableCell::words(quantity(law)),
                               TableCell::words(law.across ? "configurations" : "checkpoints"),
                               TableCell::count(rate.seeds)};
  const std::optional<RateFit>& fit = rate.fit;
  cells.push_back(fit ? TableCell::count(fit->points) : TableCell{});
  cells.push_back(fit ? TableCell::words(fmt::format("{}–{}", format_short(fit->from), format_short(fit->to))) : TableCell{});
  add_number(cells, fit ? std::optional(fit->from) : std::nullopt);
  add_number(cells, fit ? std::optional(fit->to) : std::nullopt);
  const std::string dagger = fit && rate.seeds < enough_seeds ? " †" : "";
  cells.push_back(fit ? TableCell::number(fit->exponent, with_interval(*fit) + dagger) : TableCell::words(rate.problem));
  add_number(cells, fit ? std::optional(fit->exponent) : std::nullopt);
  const auto end = [](const std::optional<Interval>& interval, double Interval::*side) {
    return interval ? std::optional((*interval).*side) : std::nullopt;
  };
  const std::optional<Interval> none;
  add_number(cells, end(fit ? fit->exponent_interval : none, &Interval::low));
  add_number(cells, end(fit ? fit->exponent_interval : none, &Interval::high));
  cells.push_back(TableCell::number(law.exponent, law.exponent_text));
  cells.push_back(TableCell::words(verdict(rate)));
  const bool plateau = fit && law.model == RateLaw::Model::plateau;
  std::string text = plateau ? format_figure(fit->plateau) : "–";
  if (plateau && fit->plateau_interval)
    text += " (" + format_interval(fit->plateau_interval->low, fit->plateau_interval->high) + ")";
  cells.push_back(plateau ? TableCell::number(fit->plateau, text) : TableCell{});
  add_number(cells, plateau ? std::optional(fit->plateau) : std::nullopt);
  add_number(cells, end(fit ? fit->plateau_interval : none, &Interval::low));
  add_number(cells, end(fit ? fit->plateau_interval : none, &Interval::high));
  cells.push_back(TableCell::words(law.source));
  return cells;
}

// What the laws of one chart share.
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

// A right triangle below the middle of the fit, its hypotenuse of theory's slope.
void add_triangle(Chart& chart, const FittedRate& rate) {
  const RateFit& fit = *rate.fit;
  const double span = std::log(fit.to / fit.from), e = rate.law->exponent;
  // Where a plateau takes over, the decay is seen at the beginning.
  const double middle = rate.law->model == RateLaw::Model::plateau ? 0.2 : 0.5;
  const double half = std::max(0.12 * span, 0.35), x0 = fit.from * std::exp(middle * span - half), x1 = x0 * std::exp(2 * half);
  const double y0 = 0.62 * std::min(fit.value(x0), fit.value(x1) * std::pow(x0 / x1, e)), y1 = y0 * std::pow(x1 / x0, e);
  ChartSeries triangle;
  triangle.draw = ChartSeries::Draw::context;
  for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y1}, {x0, y1}, {x0, y0}}) triangle.points.push_back({x, y, y, y});
  chart.series.push_back(std::move(triangle));
  chart.labels.push_back({std::sqrt(x0 * x1), y1, "theory " + rate.law->exponent_text});
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
      if (rate->law->across) series.draw = ChartSeries::Draw::line;
      if (series.points.empty()) continue;
      chart.series.push_back(series);
      fewest = std::min(fewest, rate->seeds);
    }
    if (!rate->fit) continue;
    for (const ChartSeries& other : chart.series)
      if (other.key == rate->method && other.draw == ChartSeries::Draw::line) series.colour = other.colour;
    chart.series.push_back(fit_line(*rate, series));
    if (slopes.insert(rate->law->exponent_text).second) add_triangle(chart, *rate);
    figure.notes.push_back(fmt::format(
        "{}: fitted exponent {}, theory {}{}.", rate->method, with_interval(*rate->fit), rate->law->exponent_text,
        rate->law->model == RateLaw::Model::plateau ? fmt::format(", then a plateau at {}", format_figure(rate->fit->plateau))
                                                    : ""));
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

Table rates_table(const std::vector<FittedRate>& rates) {
  Table table{"rates", "Rates of convergence against theory", {}, {}, {"Fit", "Theory"}, {}};
  const auto add = [&](const char* key, const char* title, Audience audience, std::size_t group, bool right = true) {
    table.columns.push_back({key, title, right, audience, group});
  };
  add("scene", "scene", Audience::everyone, 0, false);
  add("region", "region", Audience::everyone, 0, false);
  add("method", "method", Audience::everyone, 0, false);
  add("quantity", "of", Audience::everyone, 1, false);
  add("points_are", "points", Audience::machines, 1, false);
  add("seeds", "seeds", Audience::everyone, 1);
  add("points", "points", Audience::everyone, 1);
  add("", "window", Audience::people, 1);
  add("from", "", Audience::machines, 1);
  add("to", "", Audience::machines, 1);
  add("", "fitted exponent (95 %)", Audience::people, 1);
  for (const char* key : {"exponent", "exponent_low", "exponent_high"}) add(key, "", Audience::machines, 1);
  add("theory", "theory", Audience::everyone, 1);
  add("contains", "contains?", Audience::everyone, 1, false);
  add("", "plateau (95 %)", Audience::people, 1);
  for (const char* key : {"plateau", "plateau_low", "plateau_high"}) add(key, "", Audience::machines, 1);
  add("source", "source", Audience::everyone, 2, false);
  for (const FittedRate& rate : rates) table.rows.push_back(table_row(rate));
  if (rates.empty()) return table;
  table.notes.push_back(
      "Weighted least squares in logarithms through the means over seeds, within the window; the interval is a 95 % bootstrap "
      "over seeds, each a whole trajectory, since the checkpoints of one run are autocorrelated.");
  table.notes.push_back(
      fmt::format("{} † fewer than ten seeds. ‡ the interval is wider than half of theory's exponent, and says little.",
                  rates.size() == 1 ? "An interval of 95 % misses the truth by chance once in twenty."
                                    : fmt::format("Of {} intervals of 95 %, about {:.1f} miss the truth by chance.",
                                                  rates.size(), 0.05 * static_cast<double>(rates.size()))));
  return table;
}

std::vector<Figure> rate_figures(const std::vector<FittedRate>& rates) {
  std::vector<ChartKey> keys;
  for (const FittedRate& rate : rates)
    if (std::find(keys.begin(), keys.end(), key_of(rate)) == keys.end()) keys.push_back(key_of(rate));
  std::vector<Figure> figures;
  for (const ChartKey& key : keys) {
    std::vector<const FittedRate*> shared;
    for (const FittedRate& rate : rates)
      if (key_of(rate) == key) shared.push_back(&rate);
    if (Figure figure = rate_figure(key, shared); !figure.empty()) figures.push_back(std::move(figure));
  }
  return figures;
}

std::string rates_finding(const std::vector<FittedRate>& rates) {
  if (rates.empty()) return {};
  std::size_t judged = 0, contained = 0, unfitted = 0;
  std::vector<std::string> missed;
  for (const FittedRate& rate : rates) {
    const auto contains = rate.contains();
    judged += contains.has_value();
    unfitted += !rate.fit;
    if (contains && *contains) ++contained;
    if (contains && !*contains)
      missed.push_back(fmt::format("{} in {} of {}: {}, theory {}", rate.method, place(rate), rate.scene,
                                   with_interval(*rate.fit), rate.law->exponent_text));
  }
  std::string text = judged == 0 ? "No interval could be made: too few seeds or points."
                                 : fmt::format("{} of {} intervals contain theory's exponent.", contained, judged);
  if (!missed.empty()) text += " Not so: " + enumerate(missed, "; ", 6) + ".";
  if (unfitted > 0 && judged > 0) text += fmt::format(" {} could not be fitted.", unfitted);
  return text;
}

}  // namespace etendue
