#include "experiments/kinds/search/search_curves.h"

#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace etendue {

namespace {

// What stays fixed in a plot, in the order in which they are shown.
using PlotKey = std::tuple<std::string, std::string, std::string, std::string, std::string, double, double>;
using Samples = std::map<std::string, std::map<double, std::vector<Measured>>>;  // by structure and abscissa

class Plots {
 public:
  void add(const SearchRecord& r, const SearchFigure& f, const std::string& set, const std::string& abscissa, double x,
           double parameter, double count) {
    const PlotKey key{r.kind, set, r.set, f.measure, abscissa, parameter, count};
    if (!samples_.contains(key)) order_.push_back(key);
    auto& structures = samples_[key];
    if (!structures.contains(f.structure)) structure_order_[key].push_back(f.structure);
    structures[f.structure][x].push_back(f.value);
  }

  std::vector<SearchPlot> plots() const {
    std::vector<SearchPlot> result;
    for (const PlotKey& key : order_) {
      const auto& [kind, set, base, measure, abscissa, parameter, count] = key;
      SearchPlot plot{kind, set, base, measure, abscissa, parameter, count, {}};
      for (const std::string& structure : structure_order_.at(key)) {
        StructureCurve curve{structure, {}};
        for (const auto& [x, values] : samples_.at(key).at(structure)) curve.points.push_back({x, joined(values)});
        plot.curves.push_back(std::move(curve));
      }
      result.push_back(std::move(plot));
    }
    return result;
  }

 private:
  static Measured joined(const std::vector<Measured>& seeds) {
    Measured all = seeds.front();
    std::vector<double> medians;
    for (const Measured& m : seeds) {
      medians.push_back(m.median);
      all.low = std::min(all.low, m.low);
      all.high = std::max(all.high, m.high);
    }
    all.median = median(medians);
    return all;
  }

  std::vector<PlotKey> order_;
  std::map<PlotKey, Samples> samples_;
  std::map<PlotKey, std::vector<std::string>> structure_order_;
};

}  // namespace

std::vector<SearchPlot> search_plots(const RunLog& log) {
  std::map<std::pair<std::string, std::string>, std::uint64_t> largest;  // count, by kind and set
  std::vector<const SearchRecord*> records = records_of<SearchRecord>(log);
  std::erase_if(records, [](const SearchRecord* record) { return !record->done(); });
  for (const SearchRecord* r : records) largest[{r->kind, r->set}] = std::max(largest[{r->kind, r->set}], r->count);
  Plots over_count, over_neighbours, over_variation;
  for (const SearchRecord* record : records) {
    const SearchRecord& r = *record;
    const std::string set = r.varies.empty() ? r.set : fmt::format("{} {}={:g}", r.set, r.varies, r.variation);
    const auto count = static_cast<double>(r.count);
    for (const SearchFigure& f : r.figures) {
      over_count.add(r, f, set, "count", count, f.parameter, 0);
      if (r.count != largest.at({r.kind, r.set})) continue;
      if (f.parameter > 0) over_neighbours.add(r, f, set, "neighbours", f.parameter, 0, count);
      if (!r.varies.empty()) over_variation.add(r, f, r.set, r.varies, r.variation, f.parameter, count);
    }
  }
  std::vector<SearchPlot> plots = over_count.plots();
  for (const Plots* more : {&over_neighbours, &over_variation})
    for (SearchPlot& plot : more->plots()) plots.push_back(std::move(plot));
  return plots;
}

std::vector<double> abscissas(const SearchPlot& plot) {
  std::set<double> xs;
  for (const StructureCurve& curve : plot.curves)
    for (const CurvePoint& point : curve.points) xs.insert(point.x);
  return {xs.begin(), xs.end()};
}

const CurvePoint* point_at(const StructureCurve& curve, double x) {
  const auto found = std::find_if(curve.points.begin(), curve.points.end(), [x](const CurvePoint& p) { return p.x == x; });
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
        const double share = gap0 / (gap0 - gap1);
        found.push_back({plot.curves[a].structure, plot.curves[b].structure, xs[i] * std::pow(xs[i + 1] / xs[i], share),
                         a0->value.high < b0->value.low && b1->value.high < a1->value.low, lead});
      }
  }
  return found;
}

}  // namespace etendue
