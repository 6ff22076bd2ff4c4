#include "experiments/kinds/search/search_curves.h"

#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace etendue {

namespace {

// Adds one seed's value; several give the median of their medians and the extremes of their quartiles.
void add(std::vector<SearchPlot>& plots, const PlotKey& key, const std::string& structure, double x, const Measured& value) {
  SearchPlot& plot = find_or_add(plots, [&](const PlotKey& p) { return p == key; }, {key, {}});
  StructureCurve& curve = find_or_add(plot.curves, [&](const auto& c) { return c.structure == structure; }, {structure, {}});
  auto point = std::ranges::find_if(curve.points, [x](const CurvePoint& p) { return p.x >= x; });
  if (point == curve.points.end() || point->x != x) point = curve.points.insert(point, {x, value, {}});
  point->medians.push_back(value.median);
  point->value = {median(point->medians), std::min(point->value.low, value.low), std::max(point->value.high, value.high)};
}

}  // namespace

std::vector<SearchPlot> search_plots(const RunLog& log) {
  std::map<std::pair<std::string, std::string>, std::uint64_t> largest;  // count, by kind and set
  const std::vector<const SearchRecord*> records = done_records_of<SearchRecord>(log);
  for (const SearchRecord* r : records) largest[{r->kind, r->set}] = std::max(largest[{r->kind, r->set}], r->count);
  std::vector<SearchPlot> over_count, over_neighbours, over_variation;
  for (const SearchRecord* r : records)
    for (const SearchFigure& f : r->figures) {
      const std::string set = r->varies.empty() ? r->set : fmt::format("{} {}={:g}", r->set, r->varies, r->variation);
      const auto count = static_cast<double>(r->count);
      add(over_count, {r->kind, set, r->set, f.measure, "count", f.parameter, 0}, f.structure, count, f.value);
      if (r->count != largest.at({r->kind, r->set})) continue;
      if (f.parameter > 0)
        add(over_neighbours, {r->kind, set, r->set, f.measure, "neighbours", 0, count}, f.structure, f.parameter, f.value);
      if (!r->varies.empty())
        add(over_variation, {r->kind, r->set, r->set, f.measure, r->varies, f.parameter, count}, f.structure, r->variation,
            f.value);
    }
  std::vector<SearchPlot> plots = std::move(over_count);
  for (auto* more : {&over_neighbours, &over_variation}) std::move(more->begin(), more->end(), std::back_inserter(plots));
  return plots;
}

std::vector<double> abscissas(const SearchPlot& plot) {
  std::set<double> xs;
  for (const StructureCurve& curve : plot.curves)
    for (const CurvePoint& point : curve.points) xs.insert(point.x);
  return {xs.begin(), xs.end()};
}

const CurvePoint* point_at(const StructureCurve& curve, double x) {
  const auto found = std::ranges::find_if(curve.points, [x](const CurvePoint& p) { return p.x == x; });
  return found == curve.points.end() ? nullptr : &*found;
}

std::optional<std::size_t> leader_at(const SearchPlot& plot, double x) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    const CurvePoint* const point = point_at(plot.curves[i], x);
    if (point && (!best || point->value.median < point_at(plot.curves[*best], x)->value.median)) best = i;
  }
  return best;
}

std::vector<Crossover> crossovers(const SearchPlot& plot) {
  std::vector<Crossover> found;
  const std::vector<double> xs = abscissas(plot);
  for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
    const auto before = leader_at(plot, xs[i]), after = leader_at(plot, xs[i + 1]);
    for (std::size_t a = 0; a < plot.curves.size(); ++a)
      for (std::size_t b = 0; b < plot.curves.size(); ++b) {
        const CurvePoint *a0 = point_at(plot.curves[a], xs[i]), *a1 = point_at(plot.curves[a], xs[i + 1]);
        const CurvePoint *b0 = point_at(plot.curves[b], xs[i]), *b1 = point_at(plot.curves[b], xs[i + 1]);
        if (a == b || !a0 || !a1 || !b0 || !b1) continue;
        if (!(a0->value.median > 0 && a1->value.median > 0 && b0->value.median > 0 && b1->value.median > 0)) continue;
        const double gap0 = std::log(b0->value.median / a0->value.median), gap1 = std::log(b1->value.median / a1->value.median);
        const bool lead = before == a && after == b;
        if (!(gap0 >= 0 && gap1 < 0) || !(lead || plot.curves[a].structure == "brute")) continue;
        found.push_back({plot.curves[a].structure, plot.curves[b].structure, equality_between(xs[i], gap0, xs[i + 1], gap1),
                         a0->value.high < b0->value.low && b1->value.high < a1->value.low, lead});
      }
  }
  return found;
}

}  // namespace etendue
