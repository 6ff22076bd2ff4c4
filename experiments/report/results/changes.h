// Figures that moved between two logs of one experiment: every figure that its tables give with an interval, then and now.
//
// An interval is a pair of columns beside the figure's own: K, K_low and K_high; K_mean, K_low and K_high; or median or
// measured, low and high. What K_interval calls "min-max", the extremes of two seeds, or "none", a single one, is none. Rows
// are the same where the words are that stand beside each group of their table, but for those that say what was found, such as
// verdicts; of rows with equal words the first is held against the first, and so on. Errors at a scene's common time are
// compared where that time is the same to 1 %.
//
// The older log is gone once the newer has taken its place, so what moved is kept beside that as data: a line that says between
// which commits and how many figures were compared, a line for each figure that moved, with tabs between its fields, and a
// checksum of those lines. changes.md and the table over all experiments are derived from it.
#pragma once

#include "experiments/report/table_format.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

struct FigureChange {
  std::string table, row, column;  // the row's words, and the column's key
  double then = 0, now = 0;
  double then_low = 0, then_high = 0, now_low = 0, now_high = 0;

  bool moved() const { return now_low > then_high || now_high < then_low; }  // beyond what either interval allows
  std::optional<double> ratio() const;                                       // now / then; nullopt unless both are positive
  std::optional<bool> got_worse() const;  // nullopt where the column's key does not say whether less or more is better
};

struct LogChanges {
  std::string from, to;  // the commits of the logs
  std::size_t compared = 0, moved = 0, better = 0, worse = 0;
  std::vector<FigureChange> most;  // those that moved by the largest factors, the farthest first, at most 12

  std::string sentence() const;  // "From A to B. 12 figures with intervals were compared; those of 3 do not overlap."
};

// Compares the tables that both have, in the order of `now`; figures that only one of them has are left out.
std::vector<FigureChange> compare_tables(std::span<const Table> then, std::span<const Table> now);

LogChanges changes_between(const std::string& from, std::span<const Table> then, const std::string& to,
                           std::span<const Table> now);

std::string to_text(const LogChanges& changes);
// Throws Error where the text of `file` is not as to_text wrote it.
LogChanges read_changes(const std::string& file, std::string_view text);

// The figures that are kept, as a page of Markdown.
std::string changes_page(const LogChanges& changes);

// A row for each experiment: how many figures moved, how many of them for the better or the worse, and which by the most.
Table moved_table(const std::map<std::string, LogChanges>& experiments);

}  // namespace etendue
