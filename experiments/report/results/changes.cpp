#include "experiments/report/results/changes.h"

#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/error.h"
#include "framework/core/lists.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

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
  constexpr Spelling spellings[]{
      {"", "_low", "_high"}, {"_mean", "_low", "_high"}, {"median", "low", "high"}, {"measured", "low", "high"}};
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

// Columns whose words say what was found, and change when a figure moves.
constexpr std::array found_words{"interval", "same_image", "verdict", "why", "with", "without"};

// The words of a row: columns of words are set flush left. Those of a later group go with the figures.
std::string row_name(const Table& table, const std::vector<TableCell>& row) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (const TableColumn& column = table.columns[i]; !column.right && column.audience == Audience::everyone &&
                                                      column.group == 0 && !row[i].raw.empty() &&
                                                      !contains(found_words, column.key))
      words.push_back(row[i].raw);
  return joined(words, ", ");
}

using NamedRows = std::map<std::string, std::vector<const std::vector<TableCell>*>>;
NamedRows rows_by_name(const Table& table) {
  NamedRows rows;
  for (const auto& row : table.rows) rows[row_name(table, row)].push_back(&row);
  return rows;
}

struct FigureValue {
  double centre, low, high;
};
std::optional<FigureValue> figure_in(const std::vector<TableCell>& row, const FigureColumns& columns) {
  if (columns.what && row[*columns.what].raw != "t95") return std::nullopt;
  const auto centre = row[columns.centre].order, low = row[columns.low].order, high = row[columns.high].order;
  const auto is_known = [](const std::optional<double>& value) { return value && std::isfinite(*value); };
  return is_known(centre) && is_known(low) && is_known(high) ? std::optional(FigureValue{*centre, *low, *high}) : std::nullopt;
}

// Errors at equal time move with that time where iterations and not the clock end the runs: a faster program has less of it.
bool same_time(const std::string& key, const Table& now, const std::vector<TableCell>& row, const Table& then,
               const std::vector<TableCell>& earlier) {
  constexpr double slack = 0.01;
  if (key.find("_at_common_time_") == std::string::npos) return true;
  const auto a = column_of(now, "common_time_s"), b = column_of(then, "common_time_s");
  return a && b && std::abs(row[*a].order.value_or(0) - earlier[*b].order.value_or(0)) <= slack * row[*a].order.value_or(0);
}

constexpr std::string_view first_word = "changes";  // of the data

// The figures of a change in the order in which a line has them.
constexpr std::array change_figures{&FigureChange::then, &FigureChange::then_low, &FigureChange::then_high,
                                    &FigureChange::now,  &FigureChange::now_low,  &FigureChange::now_high};

std::string field(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\t' || c == '\n'; }, ' ');
  return text;
}

FigureChange read_change(const std::vector<std::string>& fields) {
  FigureChange change{fields.at(0), fields.at(1), fields.at(2)};
  for (std::size_t i = 0; i < change_figures.size(); ++i) change.*change_figures[i] = parse_number(fields.at(3 + i)).value();
  return change;
}

constexpr std::size_t kept_rows = 12;

}  // namespace

std::optional<double> FigureChange::ratio() const { return then > 0 && now > 0 ? std::optional(now / then) : std::nullopt; }

std::optional<bool> FigureChange::got_worse() const {
  std::string_view key = column;
  for (const std::string_view end : {"_mean", "_median"})
    if (key.ends_with(end)) key.remove_suffix(end.size());
  const auto ends_with = [&](std::string_view end) { return key.ends_with(end); };
  const auto holds = [&](std::string_view part) { return key.find(part) != std::string_view::npos; };
  constexpr std::array more{"_per_s", "_to_embree", "_to_robust_embree"};
  constexpr std::array less{"_s", "_bytes"};
  if (std::ranges::any_of(more, ends_with)) return now < then;
  if (holds("mse") || std::ranges::any_of(less, ends_with)) return now > then;
  return std::nullopt;
}

std::string LogChanges::sentence() const {
  return fmt::format("From {} to {}. {} figures with intervals were compared; those of {} do not overlap.", from, to, compared,
                     moved);
}

std::vector<FigureChange> compare_tables(std::span<const Table> then, std::span<const Table> now) {
  std::vector<FigureChange> changes;
  for (const Table& table : now) {
    const auto before = std::ranges::find_if(then, [&](const Table& t) { return t.name == table.name; });
    if (before == then.end()) continue;
    const NamedRows rows = rows_by_name(*before), rows_now = rows_by_name(table);
    std::map<std::string, std::size_t> seen;
    for (const auto& row : table.rows) {
      const std::string name = row_name(table, row);
      const std::size_t nth = seen[name]++;
      const auto same = rows.find(name);
      // Rows that only numbers tell apart are paired in order, which says nothing where one of them is missing.
      if (same == rows.end() || same->second.size() != rows_now.at(name).size()) continue;
      for (const FigureColumns& columns : figure_columns(table))
        for (const FigureColumns& old : figure_columns(*before)) {
          if (old.key != columns.key || !same_time(old.key, table, row, *before, *same->second[nth])) continue;
          const auto value = figure_in(row, columns), earlier = figure_in(*same->second[nth], old);
          if (value && earlier)
            changes.push_back({table.name, name, columns.key, earlier->centre, value->centre, earlier->low, earlier->high,
                               value->low, value->high});
        }
    }
  }
  return changes;
}

LogChanges changes_between(const std::string& from, std::span<const Table> then, const std::string& to,
                           std::span<const Table> now) {
  std::vector<FigureChange> all = compare_tables(then, now);
  const std::size_t compared = all.size();
  std::erase_if(all, [](const FigureChange& change) { return !change.moved(); });
  const auto count = [&](bool worse) {
    return static_cast<std::size_t>(std::ranges::count_if(all, [&](const FigureChange& c) { return c.got_worse() == worse; }));
  };
  LogChanges changes{from, to, compared, all.size(), count(false), count(true), std::move(all)};
  // Those without a ratio come last, in their order.
  std::ranges::stable_sort(changes.most, std::ranges::greater(), [](const FigureChange& change) {
    return change.ratio() ? std::abs(std::log(*change.ratio())) : -1;
  });
  changes.most.resize(std::min(changes.most.size(), kept_rows));
  return changes;
}

std::string to_text(const LogChanges& changes) {
  std::string text = fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\n", first_word, changes.from, changes.to, changes.compared,
                                 changes.moved, changes.better, changes.worse);
  for (const FigureChange& change : changes.most) {
    text += fmt::format("{}\t{}\t{}", field(change.table), field(change.row), field(change.column));
    for (const auto figure : change_figures) text += fmt::format("\t{:.4g}", change.*figure);
    text += '\n';
  }
  return text + hash_text(text) + "\n";
}

LogChanges read_changes(const std::string& file, std::string_view text) {
  const std::size_t end = text.size() < 2 ? std::string_view::npos : text.rfind('\n', text.size() - 2);
  const std::string_view body = text.substr(0, end == std::string_view::npos ? 0 : end + 1);
  if (body.empty() || text.substr(body.size()) != hash_text(body) + "\n")
    throw Error(Location{file}, "the checksum is wrong, so the text is not as `etendue results` wrote it");
  LogChanges changes;
  for (const std::string& line : split(body.substr(0, end), "\n")) {
    const std::vector<std::string> fields = split(line, "\t");
    if (fields[0] != first_word) {
      changes.most.push_back(read_change(fields));
      continue;
    }
    const auto count = [&](std::size_t i) { return parse_whole<std::size_t>(fields.at(i)).value(); };
    changes = {fields.at(1), fields.at(2), count(3), count(4), count(5), count(6), {}};
  }
  return changes;
}

std::string changes_page(const LogChanges& changes) {
  TableOf<FigureChange> table("changes", "What moved since the log before", changes.most);
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
  table.column("ratio", "now / then", &FigureChange::ratio);
  table.column("got", "got", [](const FigureChange& c) {
    return std::string(!c.got_worse() ? "" : *c.got_worse() ? "worse" : "better");
  });
  Table result = table.take();
  result.notes.push_back(changes.sentence());
  if (changes.most.size() < changes.moved)
    result.notes.push_back(fmt::format("These are the {} that moved by the largest factors.", changes.most.size()));
  return to_markdown(result);
}

Table moved_table(const std::map<std::string, LogChanges>& experiments) {
  using Row = std::pair<std::string, LogChanges>;
  TableOf<Row> table("moved", "What moved since the last logs", {experiments.begin(), experiments.end()});
  table.column("experiment", "experiment", &Row::first);
  table.column("from", "from", [](const Row& row) { return row.second.from; });
  table.column("to", "to", [](const Row& row) { return row.second.to; });
  table.column("compared", "figures compared", [](const Row& row) { return row.second.compared; });
  table.column("moved", "moved", [](const Row& row) { return row.second.moved; });
  table.column("better", "better", [](const Row& row) { return row.second.better; });
  table.column("worse", "worse", [](const Row& row) { return row.second.worse; });
  table.column("most", "most", [](const Row& row) {
    const std::vector<FigureChange>& most = row.second.most;
    const auto ratio = most.empty() ? std::nullopt : most.front().ratio();
    return ratio ? TableCell(*ratio, format_figure(*ratio) + "×") : TableCell();
  });
  table.column("of", "of", [](const Row& row) {
    const std::vector<FigureChange>& most = row.second.most;
    if (most.empty() || !most.front().ratio()) return std::string();
    return fmt::format("{} of {} ({})", most.front().column, most.front().row, most.front().table);
  });
  return table.take();
}

}  // namespace etendue
