// One table, written for readers (Markdown aligned for a terminal, TeX with booktabs, HTML that sorts) and for programs (CSV).
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue {

// A cell as readers see it, as programs read it ("" where nothing was measured), and as its column is sorted.
struct TableCell {
  std::string text = "–";
  std::string raw;
  std::optional<double> order;

  TableCell() = default;
  TableCell(std::string shown, std::string read, std::optional<double> sorted)
      : text(std::move(shown)), raw(std::move(read)), order(sorted) {}
  TableCell(const std::string& words) {  // "": nothing
    if (!words.empty()) text = raw = words;
  }
  TableCell(const char* words) : TableCell(std::string(words)) {}
  TableCell(double value);  // with three significant digits
  TableCell(double value, std::string shown);
  TableCell(double value, std::string (*format)(double)) : TableCell(value, format(value)) {}
  TableCell(std::integral auto count) : TableCell(static_cast<double>(count), std::to_string(count)) { raw = text; }
  template <class Value>
  TableCell(const std::optional<Value>& value) : TableCell(value ? TableCell(*value) : TableCell()) {}

  static TableCell interval(double value, double low, double high);              // "1.2e-3 (1e-3–1.4e-3)"
  static TableCell ordered(const std::string& words, std::optional<double> by);  // sorted as that figure; "": nothing
  static TableCell positive(double value, std::string (*format)(double));        // nothing unless it is above zero
};

// How many times the least error an error is, "1.23x"; infinite: there was no image to have one.
TableCell times_cell(double factor);

// A reader's column may gather what takes several for a program: "1.2e-3 (1e-3–1.4e-3)".
enum class Audience : std::uint8_t { everyone, people, machines };

struct TableColumn {
  std::string key;    // the CSV's header; for people only: unused
  std::string title;  // the reader's
  bool right = true;  // aligned right, as figures are
  Audience audience = Audience::everyone;
  std::size_t group = 0;  // on paper a wide table is cut into its groups, the columns of group 0 beside each
};

struct Table {
  std::string name;  // of the file
  std::string title;
  std::vector<TableColumn> columns = {};
  std::vector<std::vector<TableCell>> rows = {};  // a cell for each column
  std::vector<std::string> group_titles = {};     // of groups 1, 2, ...; empty: the table is narrow enough as it is
  std::vector<std::string> notes = {};
};

std::string to_markdown(const Table& table);
std::string to_csv(const Table& table);
std::string to_tex(const Table& table);  // one `table` environment a group; needs \usepackage{booktabs}
// All groups in one, all but the first folded; a table without groups that is wide folds what lies beyond its first columns.
// `csv` is a link to the same for programs, "": none.
std::string to_html(const Table& table, const std::string& csv = "");
std::string table_html(const Table& table, const std::string& csv = "");  // what the <figure> of to_html holds
std::string notes_html(const std::vector<std::string>& notes);            // a list; "" where there are none
// Writes the columns of group 0 and the chosen one without rules, for the end of a run. What is wider than 100 columns is made
// narrower, step by step until it fits: headings take several lines, what is the same in all rows is said once above them
// (columns, then parameters within a name), and names take several lines. What fits by none of these has a block for each row,
// of lines "heading: value". No line is longer than 100 columns, but for a longer word.
std::string to_terminal(const Table& table, std::size_t group);

// Lists the columns a reader sees, those that some row fills: of all groups, or of group 0 and the chosen one.
inline constexpr std::size_t all_groups = static_cast<std::size_t>(-1);
std::vector<std::size_t> visible_columns(const Table& table, std::size_t group = all_groups);

// Finds the column of that key among a program's.
std::optional<std::size_t> column_of(const Table& table, std::string_view key);

void check_shape(const Table& table);  // CHECKs that each row has a cell for each column

// Does what TableOf needs for each column; it is compiled once.
void add_column(Table& table, std::string&& key, std::string&& title, bool right, Audience audience, std::size_t group);
void add_cell(Table& table, std::size_t row, TableCell cell);

}  // namespace etendue
