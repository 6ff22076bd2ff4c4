// What moved between two logs of one experiment: every figure that its tables give with an interval, then and now.
//
// An interval is a pair of columns beside the figure's own: K, K_low and K_high; K_mean, K_low and K_high; or median, low and
// high. The extremes of two seeds, which K_interval calls "min-max", are none. Rows are the same where their words are; of rows
// with equal words the first is held against the first, and so on.
#pragma once

#include "experiments/report/table_format.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

struct FigureChange {
  std::string table, row, column;  // the row's words, and the column's key
  double then = 0, now = 0;
  double then_low = 0, then_high = 0, now_low = 0, now_high = 0;

  bool moved() const { return now_low > then_high || now_high < then_low; }  // beyond what either interval allows
};

// Compares the tables that both have, in the order of `now`; figures that only one of them has are left out.
std::vector<FigureChange> compare_tables(std::span<const Table> then, std::span<const Table> now);

// The figures that moved, with a note that says how many were compared.
Table changes_table(std::span<const FigureChange> changes);

}  // namespace etendue
