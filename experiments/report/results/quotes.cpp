#include "experiments/report/results/quotes.h"

#include "experiments/report/report_text.h"
#include "framework/core/lists.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

using Words = std::vector<std::string>;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \n"), last = text.find_last_not_of(" \n");
  return first == std::string_view::npos ? std::string_view() : text.substr(first, last - first + 1);
}

// Takes what stands before `end`, behind which `text` then begins; all of it where there is no `end`.
std::string_view cut(std::string_view& text, std::string_view end) {
  const std::size_t at = text.find(end);
  const std::string_view head = trimmed(text.substr(0, at));
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + end.size());
  return head;
}

// Which rows of a table give a figure, and how.
enum class Pick { only, least, most, count };

struct QuotedFigure {
  const Table* table = nullptr;
  Pick choice = Pick::only;
  std::size_t column = 0;
  Words words;
};

// A figure, over another one where there are two, and its notation.
struct Quote {
  std::vector<QuotedFigure> figures;
  std::string_view notation;
};

std::size_t column_named(const Table& table, std::string_view key) {
  if (const auto column = column_of(table, key)) return *column;
  throw Error(unknown_name("column", key, mapped(table.columns, &TableColumn::key)));
}

const Table& table_named(std::string_view name, const TableSource& tables) {
  const std::string folder(cut(name, "/"));
  if (folder.empty() || name.empty()) throw Error("a table that cannot be read; expected FOLDER/TABLE");
  return tables(folder, std::string(name));
}

// Reads "[cornell-box, path]"; what is empty has no words. A comma within a word has no space behind it.
Words quoted_words(std::string_view text) {
  Words words;
  if (text.empty()) return words;
  if (!text.starts_with('[') || !text.ends_with(']')) throw Error(fmt::format("'{}'; expected [WORD, WORD, …]", text));
  text = text.substr(1, text.size() - 2);
  while (!trimmed(text).empty()) {
    std::size_t comma = text.find(',');
    while (comma != std::string_view::npos && text.substr(comma + 1).find_first_of(" \n") != 0)
      comma = text.find(',', comma + 1);
    words.emplace_back(trimmed(text.substr(0, comma)));
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  }
  return words;
}

// Reads "least first-light/final relmse_median [cornell-box]", without the table where `given` is the one.
QuotedFigure figure_of(std::string_view text, const Table* given, const TableSource& tables) {
  const auto cannot = [] { return Error("a figure that cannot be read; expected FOLDER/TABLE COLUMN [WORD, WORD, …]"); };
  const std::size_t bracket = std::min(text.find('['), text.size());
  std::string_view head = trimmed(text.substr(0, bracket));
  QuotedFigure figure{given, Pick::only, 0, quoted_words(trimmed(text.substr(bracket)))};
  if (!given && bracket == text.size()) throw cannot();
  for (const auto& [name, choice] : {std::pair("least", Pick::least), {"most", Pick::most}, {"count", Pick::count}})
    if (head == name || head.starts_with(std::string(name) + " ")) {
      figure.choice = choice;
      cut(head, name);
      break;
    }
  head = trimmed(head);
  if (!given) figure.table = &table_named(cut(head, " "), tables);
  if ((figure.choice == Pick::count) != trimmed(head).empty()) throw cannot();
  if (figure.choice != Pick::count) figure.column = column_named(*figure.table, trimmed(head));
  return figure;
}

// Reads one figure or "A [...] / B [...]", with "as NOTATION" behind.
Quote quote_of(std::string_view text, const Table* given, const TableSource& tables) {
  Quote quote;
  const std::size_t as = text.rfind(" as ");
  if (as != std::string_view::npos && text.find(']', as) == std::string_view::npos) {
    quote.notation = trimmed(text.substr(as + 4));
    text = text.substr(0, as);
  }
  const std::size_t over = text.find("] /");
  quote.figures.push_back(figure_of(trimmed(text.substr(0, over == std::string_view::npos ? over : over + 1)), given, tables));
  if (over != std::string_view::npos) quote.figures.push_back(figure_of(trimmed(text.substr(over + 3)), given, tables));
  return quote;
}

// The name of a scene: a built-in one without "builtin:", a file without its folder and ending. Other texts stay as they are.
std::string_view short_name(std::string_view text) {
  if (text.starts_with("builtin:")) return text.substr(8);
  if (text.find('/') == std::string_view::npos || text.find(' ') != std::string_view::npos) return text;
  const std::string_view file = text.substr(text.rfind('/') + 1);
  return file.substr(0, file.rfind('.'));
}

bool is_named(const TableCell& cell, std::string_view word) { return cell.raw == word || short_name(cell.raw) == word; }

bool has_word(const Table& table, const std::vector<TableCell>& row, std::string_view word) {
  if (word.starts_with("not ")) return !has_word(table, row, word.substr(4));
  const std::size_t equals = word.find('=');
  if (const auto column = column_of(table, word.substr(0, equals)); column && equals != std::string_view::npos)
    return is_named(row[*column], word.substr(equals + 1));
  const auto has_part = [&](const TableCell& cell) {
    return equals != std::string_view::npos && (" " + cell.raw + " ").find(fmt::format(" {} ", word)) != std::string::npos;
  };
  return std::ranges::any_of(row, [&](const TableCell& cell) { return is_named(cell, word) || has_part(cell); });
}

// Throws Error where a word KEY=TEXT is neither of a column nor a part of any row: a slip behind "not" would choose all.
void check_words(const Table& table, const Words& words) {
  for (std::string_view word : words) {
    if (word.starts_with("not ")) word.remove_prefix(4);
    const std::size_t equals = word.find('=');
    if (equals == std::string_view::npos || column_of(table, word.substr(0, equals)) || table.rows.empty()) continue;
    if (std::ranges::none_of(table.rows, [&](const auto& row) { return has_word(table, row, word); }))
      throw Error(fmt::format("'{}' in {}; expected a column's name before '=', or a part of a row", word, table.name));
  }
}

std::vector<const std::vector<TableCell>*> rows_with(const Table& table, const Words& words) {
  check_words(table, words);
  std::vector<const std::vector<TableCell>*> found;
  for (const auto& row : table.rows)
    if (std::ranges::all_of(words, [&](const std::string& word) { return has_word(table, row, word); })) found.push_back(&row);
  return found;
}

std::optional<double> trimmed_number(std::string_view text) { return parse_number(trimmed(text)); }

// The text that the log's own table shows there: for a column that only programs read, the readers' column it belongs to.
std::string shown_text(const QuotedFigure& figure, const std::vector<TableCell>& row) {
  std::size_t at = figure.column;
  while (at > 0 && figure.table->columns[at].audience == Audience::machines) --at;
  return row[figure.table->columns[at].audience == Audience::machines ? figure.column : at].text;
}

// The value of a figure; none where no row has its words or the only one has nothing there. "as text" is for one row alone,
// whose text goes to `text`.
std::optional<double> value_of(const QuotedFigure& figure, std::string* text) {
  const auto rows = rows_with(*figure.table, figure.words);
  if (figure.choice == Pick::count) return static_cast<double>(rows.size());
  if (figure.choice == Pick::only && rows.size() > 1)
    throw Error(fmt::format("{} rows of {} have all of [{}]; expected one", rows.size(), figure.table->name,
                            fmt::join(figure.words, ", ")));
  std::optional<double> chosen;
  for (const auto* row : rows) {
    const std::string& raw = (*row)[figure.column].raw;
    const auto value = trimmed_number(raw);
    if (!value && !raw.empty() && figure.choice != Pick::only)  // such as "no image", which is worse than any
      throw Error(fmt::format("a row of {} has '{}' in {}; expected a number in each, or words that leave it out",
                              figure.table->name, raw, figure.table->columns[figure.column].key));
    if (text && figure.choice == Pick::only) *text = shown_text(figure, *row);
    if (value && (!chosen || (figure.choice == Pick::least ? *value < *chosen : *value > *chosen))) chosen = value;
  }
  return chosen;
}

std::string notation(double value, std::string_view format) {
  if (format.empty()) {
    const bool count = value == std::floor(value) && std::abs(value) < 1e6;
    return count ? fmt::format("{:.0f}", value) : format_figure(value, 2);
  }
  if (format.find('*') != std::string_view::npos) {
    const std::string_view factor = cut(format, "*");
    if (!trimmed_number(factor)) throw Error(fmt::format("the factor '{}'; expected a number", factor));
    value *= *trimmed_number(factor);
  }
  try {
    return fmt::format(fmt::runtime(fmt::format("{{:{}}}", trimmed(format))), value);
  } catch (const fmt::format_error&) {
    throw Error(fmt::format("the notation '{}'; expected a format of {{fmt}} such as .2f", trimmed(format)));
  }
}

// A quote as it is shown; "" where there is nothing to show. Only a cell of a table may be other than a number.
std::string shown(const Quote& quote, bool in_table) {
  std::string text;
  const auto value = value_of(quote.figures[0], &text);
  if (quote.notation == "text" && quote.figures.size() == 1 && !text.empty()) return text;
  if (quote.figures.size() == 1) return value ? notation(*value, quote.notation) : in_table ? text : "";
  const auto under = value_of(quote.figures[1], nullptr);
  return value && under ? notation(*value / *under, quote.notation) : "";
}

std::string figure_text(std::string_view marker, const TableSource& tables) {
  const Quote quote = quote_of(marker, nullptr, tables);
  if (std::string text = shown(quote, false); !text.empty()) return text;
  for (const QuotedFigure& figure : quote.figures)
    if (rows_with(*figure.table, figure.words).empty())
      throw Error(
          fmt::format("0 rows of {} have all of [{}]; expected one", figure.table->name, fmt::join(figure.words, ", ")));
  throw Error(fmt::format("{} is not there as a number; expected a number", marker));
}

// A row or a column of a table: what it is called, and the words of its figures.
struct TableLine {
  std::string label;
  Words words;
};

// A line for each text that a column has among the rows of those words.
std::vector<TableLine> lines_by(const Table& table, std::string_view key, const Words& words) {
  const std::size_t column = column_named(table, key);
  std::vector<TableLine> lines;
  for (const auto* row : rows_with(table, words)) {
    const TableCell& cell = (*row)[column];
    const std::string label = escape_markdown(short_name(cell.text));
    if (std::ranges::none_of(lines, [&](const TableLine& other) { return other.label == label; }))
      lines.push_back({label, {fmt::format("{}={}", key, cell.raw)}});
  }
  return lines;
}

// Reads what follows "row" or "rows": "[path, sah]", or "integrator [sah]" for several.
std::vector<TableLine> rows_of(std::string_view kind, std::string_view line, std::string_view label, const Table& table) {
  if (kind == "rows") {
    const std::string_view key = cut(line, " ");
    return lines_by(table, key, quoted_words(trimmed(line)));
  }
  const Words words = quoted_words(trimmed(line));
  return {{label.empty() ? joined(words, ", ") : std::string(label), words}};
}

Quote with_words(Quote quote, const Words& words) {
  for (QuotedFigure& figure : quote.figures) figure.words.insert(figure.words.end(), words.begin(), words.end());
  return quote;
}

// Takes the first of a table's lines, which end at ";" as well.
std::string_view cut_line(std::string_view& text) {
  const std::size_t end = text.find_first_of("\n;");
  return cut(text, text.substr(std::min(end, text.size()), 1) == ";" ? ";" : "\n");
}

std::string table_text(std::string_view marker, const TableSource& tables) {
  std::string_view name = cut_line(marker);
  const Table& table = table_named(cut(name, " : "), tables);
  std::string head = fmt::format("| {} |", trimmed(name)), rule = "|---|", body;
  std::vector<Quote> columns;
  while (!trimmed(marker).empty()) {
    std::string_view label = cut_line(marker);
    if (label.empty()) continue;
    std::string_view line = cut(label, " : ");
    label = trimmed(label);
    const std::string_view kind = cut(line, " ");
    if (kind == "column" || kind == "columns") {
      const std::string_view by = kind == "columns" ? cut(line, " ") : std::string_view();
      const Quote quote = quote_of(trimmed(line), &table, tables);
      const TableColumn& shows = table.columns[quote.figures[0].column];
      const TableLine one{std::string(label.empty() ? shows.title : label), {}};
      for (const TableLine& column : by.empty() ? std::vector{one} : lines_by(table, by, quote.figures[0].words)) {
        columns.push_back(with_words(quote, column.words));
        head += fmt::format(" {}{} |", column.label, by.empty() || label.empty() ? "" : fmt::format(", {}", label));
        rule += shows.right ? "---:|" : "---|";
      }
      continue;
    }
    if (kind != "row" && kind != "rows")
      throw Error(fmt::format("'{}' in a table; expected column, columns, row or rows", kind));
    for (const TableLine& row : rows_of(kind, line, label, table)) {
      bool any = false;
      body += fmt::format("\n| {} |", row.label);
      for (const Quote& column : columns) {
        const std::string text = shown(with_words(column, row.words), true);
        any |= !text.empty();
        body += fmt::format(" {} |", text.empty() ? "–" : escape_markdown(text));
      }
      if (!any) throw Error(fmt::format("no figure of the table's columns has [{}]", fmt::join(row.words, ", ")));
    }
  }
  if (columns.empty() || body.empty())
    throw Error("a table without columns or rows; expected lines of column, then of row or rows");
  return fmt::format("\n{}\n{}{}\n", head, rule, body);
}

// A kind of marker: how it opens, what ends it, and what stands between.
struct Marker {
  std::string_view open, end, name;
  std::string (*text)(std::string_view, const TableSource&);
};

constexpr Marker markers[] = {{"<!--=", "<!--/-->", "figure", figure_text},
                              {"<!--table", "<!--/table-->", "table", table_text}};

}  // namespace

std::string fill_quotes(const std::string& file, std::string_view text, const TableSource& tables) {
  constexpr std::string_view closing = "-->";
  std::string filled;
  std::size_t done = 0;
  const auto next = [&](std::size_t from) {
    return std::ranges::min_element(markers, {}, [&, from](const Marker& marker) { return text.find(marker.open, from); });
  };
  for (std::size_t at; (at = text.find(next(done)->open, done)) != std::string_view::npos;) {
    const Marker& marker = *next(done);
    const Location where = location_at(file, text, at);
    const std::size_t close = text.find(closing, at), end = text.find(marker.end, at);
    if (end == std::string_view::npos || text.find(next(at + 1)->open, at + 1) < end)
      throw Error(where, fmt::format("a {} without its end; expected {}", marker.name, marker.end));
    filled += text.substr(done, close + closing.size() - done);
    try {
      filled += marker.text(trimmed(text.substr(at + marker.open.size(), close - at - marker.open.size())), tables);
    } catch (const Error& e) {
      throw Error(where, e.what());
    }
    filled += marker.end;
    done = end + marker.end.size();
  }
  return filled + std::string(text.substr(done));
}

}  // namespace etendue
