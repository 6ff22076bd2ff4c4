// The report of a failure map: the matrix of hazards and methods as a figure and a table, thresholds with intervals against
// what theory expects of them, remedies as factors by which thresholds moved, a curve and images for each cell, and heat maps
// of hazards with two parameters.
#pragma once

#include "experiments/kinds/stress/stress_record.h"
#include "experiments/report/kind_report.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

// A cell of the map, as the log has it. A record that failed or does not apply has no threshold.
struct StressCell {
  const StressRecord* record = nullptr;
  std::optional<Threshold> threshold = {};

  double x() const { return record->range.at(threshold->t); }
  Interval x_interval() const;         // an end is infinite or 0 where the range says no more
  std::string threshold_text() const;  // "0.097", "holds", "fails", "–"
  std::string interval_text() const;   // "0.09–0.1"; "" where there is none
  TableCell interval_cell() const;     // sorted by its lower end
  std::string verdict_text() const;    // "fails from 0.097 m on"
  std::string anchor() const;          // of the page
  std::string name() const;            // "sppm", "sppm: side test", "sppm, radius of the kernel 0.1 m"
  // How far the image's mean is off at the harmful end, where seeds agree on it to a fifth: wrong, and calm.
  std::optional<double> calm_error() const;
};

// The cells of a hazard, those of the matrix by column, then those of remedies.
struct StressRow {
  int id = 0;
  std::vector<StressCell> cells, remedies;

  const StressRecord& record() const { return *cells.front().record; }
  const StressCell* of(const std::string& column) const;
  std::size_t broken() const;  // methods that fail within the range
};

struct StressMap {
  std::vector<std::string> columns, structure_columns;
  std::vector<StressRow> rows;   // by id
  std::vector<StressRow> grids;  // hazards with a second parameter, whose cells are the rows of a heat map, by ascending y
};

StressMap arrange_stress(const RunLog& log);
// Empty where nothing is expected. Of a row of a heat map the expected threshold is confirmed where the measured interval holds
// it.
std::optional<JudgedPrediction> judge_stress(const StressCell& cell);

std::vector<const StressCell*> all_cells(const StressMap& map);

std::string range_of(const StressRecord& record);  // "0.2 → 0.01 m"
std::string bound_of(const StressRecord& record);  // "relmse at most 0.1"
double crossed_bound(const StressRecord& record);  // the bound on whose far side the first failing point lies
std::string x_text(double x);                      // with two digits: "0.097", "7000"
std::string y_text(double y);                      // as it was chosen: "0.0125", "400 k"
std::string with_unit(const std::string& text, const std::string& unit);  // "0.097 m"
extern const char* const threshold_rule;                                  // how thresholds are found, for people

// A remedy beside what it mends.
struct MendedCell {
  const StressCell *without, *with;
  Mended mended;

  double factor() const { return mended.factor; }
  // One seed tells no gain from noise.
  bool helps() const { return mended.interval.low > 1 && without->record->points.front().values.size() > 1; }
  std::string text() const;  // "4.2×", "at least 12×"
};
std::vector<MendedCell> mended_cells(const StressMap& map);

Table matrix_table(const StressMap& map, bool structures);
Table thresholds_table(const StressMap& map);
Table remedies_table(const std::vector<MendedCell>& cells);

// A row for each cell of the matrix has tails, coverage and the time to the first sane image; notes sum them up.
Table hidden_table(const StressMap& map);
void add_hidden(const StressMap& map, KindReport& report);

// The first has a heat map's rows at the points that all of them have, with thresholds and what theory expects of them; the
// second has every point of all maps.
Table grid_table(const StressRow& grid);
Table grid_points_table(const StressMap& map);
// How many rows hold the threshold expected; "" where none is.
std::string grid_finding(const StressRow& grid);

// An element of SVG, its text escaped.
std::string drawn_text(double x, double y, const std::string& text, const std::string& style);

// The matrix, of methods or of structures; in a page its cells lead to what stands there of each.
Drawing draw_matrix(const StressMap& map, bool structures, bool linked);
Figure curve_figure(const StressMap& map, const StressRow& row);
Figure grid_figure(const StressRow& grid);

KindReport stress_report(const RunLog& log);
std::string stress_summary(const RunLog& log);  // what `etendue stress` prints at its end

}  // namespace etendue
