#include "experiments/report/results/changes.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

namespace etendue {

namespace {

struct FigureColumns {
  std::string key;
  std::size_t centre, low, high;
  std::optional<std::size_t> what;  // says what the interval is
};

std::optional<std::size_t> column_of(const Table& table, std::string_view key) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(), [&](const TableColumn& column) {
    return column.audience != Audience::people && column.key == key;
  });
  return found == table.columns.end() ? std::nullopt : std::optional<std::size_t>(found - table.columns.begin());
}

std::vector<FigureColumns> figure_columns(const Table& table) {
  struct Spelling {
    std::string_view centre, low, high;  // ends of the keys
  };
  constexpr Spelling spellings[]{{"", "_low", "_high"}, {"_mean", "_low", "_high"}, {"median", "low", "high"}};
  std::vector<FigureColumns> found;
  for (const TableColumn& column : table.columns)
    for (const auto& [centre, low, high] : spellings) {
      if (column.audience == Audience::people || !column.key.ends_with(centre)) continue;
      const std::string stem = column.key.substr(0, column.key.size() - centre.size());
      if (!stem.empty() && !centre.empty() && centre.front() != '_') continue;
      const auto at = column_of(table, column.key), at_low = column_of(table, stem + std::string(low)),
                 at_high = column_of(table, stem + std::string(high));
      if (at_low && at_high) found.push_back({column.key, *at, *at_low, *at_high, column_of(table, stem + "_interval")});
    }
  return found;
}

// The words of a row: columns of words are set flush left.
std::string row_name(const Table& table, const std::vector<TableCell>& row) {
  std::string name;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (const TableColumn& column = table.columns[i];
        !column.right && column.audience == Audience::everyone && !row[i].raw.empty())
      name += (name.empty() ? "" : ", ") + row[i].raw;
  return name;
}

using Rows = std::map<std::string, std::vector<const std::vector<TableCell>*>>;
Rows rows_by_name(const Table& table) {
  Rows rows;
  for (const auto& row : table.rows) rows[row_name(table, row)].push_back(&row);
  return rows;
}

std::optional<double> number_in(const std::vector<TableCell>& row, std::size_t column) {
  const std::string& raw = row[column].raw;
  char* end = nullptr;
  const double value = std::strtod(raw.c_str(), &end);
  return raw.empty() || *end != 0 ? std::nullopt : std::optional(value);
}

struct FigureValue {
  double centre, low, high;
};
std::optional<FigureValue> figure_in(const std::vector<TableCell>& row, const FigureColumns& columns) {
  if (columns.what && row[*columns.what].raw == "min-max") return std::nullopt;
  const auto centre = number_in(row, columns.centre), low = number_in(row, columns.low), high = number_in(row, columns.high);
  return centre && low && high ? std::optional(FigureValue{*centre, *low, *high}) : std::nullopt;
}

}  // namespace

std::vector<FigureChange> compare_tables(std::span<const Table> then, std::span<const Table> now) {
  std::vector<FigureChange> changes;
  for (const Table& table : now) {
    const auto before = std::find_if(then.begin(), then.end(), [&](const Table& t) { return t.name == table.name; });
    if (before == then.end()) continue;
    const Rows rows = rows_by_name(*before);
    std::map<std::string, std::size_t> seen;
    for (const auto& row : table.rows) {
      const std::string name = row_name(table, row);
      const std::size_t nth = seen[name]++;
      const auto same = rows.find(name);
      if (same == rows.end() || nth >= same->second.size()) continue;
      for (const FigureColumns& columns : figure_columns(table))
        for (const FigureColumns& old : figure_columns(*before)) {
          if (old.key != columns.key) continue;
          const auto value = figure_in(row, columns), earlier = figure_in(*same->second[nth], old);
          if (value && earlier)
            changes.push_back({table.name, name, columns.key, earlier->centre, value->centre, earlier->low, earlier->high,
                               value->low, value->high});
        }
    }
  }
  return changes;
}

Table changes_table(std::span<const FigureChange> changes) {
  Table table{"changes", "What moved since the last log", {}, {}, {}, {}};
  table.columns = {{"table", "table", false},
                   {"row", "row", false},
                   {"figure", "figure", false},
                   {"then", "then"},
                   {"", "interval", true, Audience::people},
                   {"now", "now"},
                   {"", "interval", true, Audience::people},
                   {"ratio", "now / then"}};
  for (const FigureChange& c : changes)
    if (c.moved())
      table.rows.push_back({TableCell::words(c.table), TableCell::words(c.row), TableCell::words(c.column),
                            TableCell::number(c.then), TableCell::words(format_interval(c.then_low, c.then_high)),
                            TableCell::number(c.now), TableCell::words(format_interval(c.now_low, c.now_high)),
                            c.then == 0 ? TableCell{} : TableCell::number(c.now / c.then)});
  table.notes.push_back(
      fmt::format("{} figures with intervals were compared; those of {} do not overlap.", changes.size(), table.rows.size()));
  return table;
}

}  // namespace etendue
