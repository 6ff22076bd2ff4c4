#include "experiments/report/results/changes.h"

#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"

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

struct FigureValue {
  double centre, low, high;
};
std::optional<FigureValue> figure_in(const std::vector<TableCell>& row, const FigureColumns& columns) {
  if (columns.what && row[*columns.what].raw == "min-max") return std::nullopt;
  const auto centre = row[columns.centre].order, low = row[columns.low].order, high = row[columns.high].order;
  return centre && low && high ? std::optional(FigureValue{*centre, *low, *high}) : std::nullopt;
}

}  // namespace

std::vector<FigureChange> compare_tables(std::span<const Table> then, std::span<const Table> now) {
  std::vector<FigureChange> changes;
  for (const Table& table : now) {
    const auto before = std::ranges::find_if(then, [&](const Table& t) { return t.name == table.name; });
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
  std::vector<FigureChange> moved;
  std::ranges::copy_if(changes, std::back_inserter(moved), [](const FigureChange& c) { return c.moved(); });
  const std::string note =
      fmt::format("{} figures with intervals were compared; those of {} do not overlap.", changes.size(), moved.size());
  TableOf<FigureChange> table("changes", "What moved since the last log", std::move(moved));
  const auto interval = [](double FigureChange::*low, double FigureChange::*high) {
    return [=](const FigureChange& c) { return TableCell(format_interval(c.*low, c.*high)); };
  };
  table.column("table", "table", &FigureChange::table);
  table.column("row", "row", &FigureChange::row);
  table.column("figure", "figure", &FigureChange::column);
  table.column("then", "then", &FigureChange::then);
  table.column("", "interval", interval(&FigureChange::then_low, &FigureChange::then_high), Audience::people);
  table.column("now", "now", &FigureChange::now);
  table.column("", "interval", interval(&FigureChange::now_low, &FigureChange::now_high), Audience::people);
  table.column("ratio", "now / then",
               [](const FigureChange& c) { return c.then == 0 ? TableCell() : TableCell(c.now / c.then); });
  Table result = table.take();
  result.notes.push_back(note);
  return result;
}

}  // namespace etendue
