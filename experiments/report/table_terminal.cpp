// Tables on a terminal, in 100 columns where that can be.
#include "experiments/config/method.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_format.h"

#include <algorithm>
#include <numeric>

namespace etendue {
namespace {

constexpr std::size_t terminal_width = 100, gap = 2;
constexpr std::size_t narrowest_name = 14, indent = 2;  // to which names are broken, and how much deeper they go on

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& word : words_of(text)) longest = std::max(longest, display_width(word));
  return longest;
}

struct TerminalColumn {
  std::string title;
  bool right;
  std::vector<std::string> cells;
  std::size_t title_width, cell_width;

  std::size_t width() const { return std::max(title_width, cell_width); }
  void measure() {
    title_width = display_width(title);
    cell_width = 3;
    for (const std::string& cell : cells) cell_width = std::max(cell_width, display_width(cell));
  }
};

class TerminalTable {
 public:
  TerminalTable(const Table& table, std::size_t group) {
    for (const std::size_t i : visible_columns(table, group)) {
      const TableColumn& from = table.columns[i];
      TerminalColumn column{from.title, from.right, {}, 0, 0};
      for (const auto& row : table.rows) column.cells.push_back(row[i].text);
      column.measure();
      columns_.push_back(std::move(column));
    }
    rows_ = table.rows.size();
  }

  std::string text() {
    fit();
    std::string out;
    for (const std::string& what : said_) out += (out.empty() ? "  in all rows: " : ", ") + what;
    if (!out.empty()) out = wrapped(out, terminal_width);
    if (!fits()) return out + blocks();
    out += lines(mapped(columns_, [](const TerminalColumn& c) { return broken_lines(c.title, c.width()); }), true);
    for (std::size_t r = 0; r < rows_; ++r) {
      const auto cell = [r](const TerminalColumn& column) {
        const std::string& text = column.cells[r];
        return display_width(text) <= column.width() ? std::vector{text} : broken_lines(text, column.width(), indent);
      };
      out += lines(mapped(columns_, cell), false);
    }
    return out;
  }

 private:
  bool fits() const {
    return terminal_width >= std::accumulate(columns_.begin(), columns_.end(), std::size_t{0},
                                             [](std::size_t sum, const TerminalColumn& c) { return sum + gap + c.width(); });
  }

  void fit() {
    if (fits()) return;
    for (TerminalColumn& column : columns_) column.title_width = std::max(longest_word(column.title), column.title_width / 2);
    for (std::size_t i = columns_.size(); i-- > 0 && !fits() && rows_ > 1;) say_column_once(i);
    const auto has_parameters = [](const auto& c) { return !c.right && c.cells.front().find('=') != std::string::npos; };
    const bool named = rows_ > 1 && std::ranges::count_if(columns_, has_parameters) > 1;
    for (TerminalColumn& column : columns_)
      if (!fits() && !column.right && rows_ > 1) say_parameters_once(column, named);
    // The widest that can be first, as far as is needed.
    while (!fits()) {
      TerminalColumn* widest = nullptr;
      for (TerminalColumn& column : columns_)
        if (!column.right && column.width() > least_width(column) && (!widest || column.width() > widest->width()))
          widest = &column;
      if (!widest) return;
      const std::size_t narrower = widest->width() - 1;
      widest->cell_width = std::min(widest->cell_width, narrower);
      widest->title_width = std::min(widest->title_width, narrower);
    }
  }

  static std::size_t least_width(const TerminalColumn& column) {
    std::size_t least = std::max(narrowest_name, longest_word(column.title));
    for (const std::string& cell : column.cells) least = std::max(least, longest_word(cell) + indent);
    return least;
  }

  // The first column's line begins a row.
  std::string blocks() const {
    std::string out;
    for (std::size_t r = 0; r < rows_; ++r)
      for (std::size_t c = 0; c < columns_.size(); ++c)
        out += wrapped(std::string(c == 0 ? gap : gap + indent, ' ') + columns_[c].title + ": " + columns_[c].cells[r],
                       terminal_width);
    return out;
  }

  void say_column_once(std::size_t i) {
    const std::vector<std::string>& cells = columns_[i].cells;
    if (std::ranges::any_of(cells, [&](const std::string& cell) { return cell != cells.front(); })) return;
    said_.insert(said_.begin(), columns_[i].title + " " + cells.front());  // columns come from the last to the first
    columns_.erase(columns_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  // "sppm k=8 photons=1M" and "ppm k=8" share k=8. The column is named where others have parameters too.
  void say_parameters_once(TerminalColumn& column, bool named) {
    for (const std::string& word : words_of(column.cells.front())) {
      if (word.find('=') == std::string::npos) continue;
      const bool shared =
          std::ranges::all_of(column.cells, [&](const std::string& cell) { return contains(words_of(cell), word); });
      if (!shared) continue;
      said_.push_back(named ? column.title + " " + word : word);
      for (std::string& cell : column.cells) {
        auto words = words_of(cell);
        std::erase(words, word);
        cell = joined(words, " ");
      }
    }
    const std::size_t title_width = column.title_width;
    column.measure();
    column.title_width = title_width;
  }

  // A row whose cells take several lines: headings stand on the last of them, cells on the first.
  std::string lines(const std::vector<std::vector<std::string>>& row, bool at_bottom) const {
    std::size_t height = 0;
    for (const auto& cell : row) height = std::max(height, cell.size());
    std::string out;
    for (std::size_t i = 0; i < height; ++i) {
      std::string line;
      for (std::size_t c = 0; c < row.size(); ++c) {
        const std::size_t above = at_bottom ? height - row[c].size() : 0;
        const bool empty = i < above || i - above >= row[c].size();
        line += std::string(gap, ' ') + padded(empty ? "" : row[c][i - above], columns_[c].width(), columns_[c].right);
      }
      line.erase(line.find_last_not_of(' ') + 1);
      out += line + "\n";
    }
    return out;
  }

  std::vector<TerminalColumn> columns_;
  std::size_t rows_ = 0;
  std::vector<std::string> said_;
};

}  // namespace

std::string to_terminal(const Table& table, std::size_t group) {
  check_shape(table);
  return TerminalTable(table, group).text();
}

}  // namespace etendue
