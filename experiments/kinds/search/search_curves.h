// From records of point or record structures to curves and to where one structure overtakes another, and what a report says of
// them.
#pragma once

#include "experiments/kinds/search/measure_search.h"
#include "experiments/report/kind_report.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct CurvePoint {
  double x = 0;
  Measured value;
  std::vector<double> medians;  // by seed
};

struct StructureCurve {
  std::string structure;
  std::vector<CurvePoint> points;  // x ascending
};

// Holds what stays fixed in a plot.
struct PlotKey {
  std::string kind;
  std::string set;       // with its variation, where that is fixed
  std::string base;      // without
  std::string measure;   // "within"
  std::string abscissa;  // "count", "neighbours", "contrast", "spread"
  double parameter = 0;  // of the measure; 0 where it has none, or where it is the abscissa
  double count = 0;      // 0: the abscissa

  bool operator==(const PlotKey&) const = default;
};

// One measure of all structures over one abscissa.
struct SearchPlot : PlotKey {
  std::vector<StructureCurve> curves;
};

// Every measure over the count; queries also over the number of neighbours, and all measures over the variation, both at the
// largest count that has them. Several seeds give the median of their medians, and the extremes of their quartiles.
std::vector<SearchPlot> search_plots(const RunLog& log);

// The size from which `overtaking` is faster than `overtaken`: log-log linear between two abscissas.
struct Crossover {
  std::string overtaken, overtaking;
  double at = 0;
  bool clear = false;  // their quartiles are apart on both sides
  bool lead = false;   // it takes the lead of all with it
};

// Crossings of brute force, and those that change the lead. Memory crosses where a structure begins to take less.
std::vector<Crossover> crossovers(const SearchPlot& plot);

// Finds the curve with the least value at x; nullopt where none is there.
std::optional<std::size_t> leader_at(const SearchPlot& plot, double x);

// Gives all abscissas of the plot, ascending.
std::vector<double> abscissas(const SearchPlot& plot);
const CurvePoint* point_at(const StructureCurve& curve, double x);

KindReport search_report(const RunLog& log);
std::string search_summary(const RunLog& log);     // what `etendue run` prints at its end
Table search_crossovers_table(const RunLog& log);  // a row for each crossing

}  // namespace etendue
