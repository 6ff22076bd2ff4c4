#include "experiments/report/results/quotes.h"

#include "experiments/report/report_text.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr std::string_view opening = "<!--=", closing = "-->", end_mark = "<!--/-->";

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

bool is_named(const TableCell& cell, std::string_view word) {
  return cell.raw == word || (cell.raw.starts_with("builtin:") && std::string_view(cell.raw).substr(8) == word);
}

double number_of(std::string_view text, const std::string& what) {
  try {
    return std::stod(std::string(text));
  } catch (const std::exception&) {
    throw Error(fmt::format("{} '{}'; expected a number", what, text));
  }
}

// Reads "first-light/final relmse_median [cornell-box, path, sah]".
double value_of(std::string_view quote, const TableSource& tables) {
  const std::string folder(cut(quote, "/")), name(cut(quote, " ")), key(cut(quote, "["));
  std::string_view words = cut(quote, "]");
  if (folder.empty() || name.empty() || key.empty() || words.empty() || !trimmed(quote).empty())
    throw Error("a figure that cannot be read; expected FOLDER/TABLE COLUMN [WORD, WORD, …]");
  const Table& table = tables(folder, name);
  const auto column = column_of(table, key);
  if (!column) {
    std::vector<std::string> keys;
    for (const TableColumn& other : table.columns) keys.push_back(other.key);
    throw Error(unknown_name("column", key, keys));
  }
  std::vector<std::string_view> wanted;
  while (!words.empty()) wanted.push_back(cut(words, ","));
  const TableCell* found = nullptr;
  std::size_t rows = 0;
  for (const auto& row : table.rows) {
    const bool fits = std::ranges::all_of(wanted, [&](std::string_view word) {
      return std::ranges::any_of(row, [&](const TableCell& cell) { return is_named(cell, word); });
    });
    if (!fits) continue;
    ++rows;
    found = &row[*column];
  }
  if (rows != 1)
    throw Error(fmt::format("{} rows of {}/{} have all of [{}]; expected one", rows, folder, name, fmt::join(wanted, ", ")));
  return number_of(found->raw, fmt::format("{} there is", key));
}

std::string notation(double value, std::string_view format) {
  if (format.empty()) {
    const bool count = value == std::floor(value) && std::abs(value) < 1e6;
    return count ? fmt::format("{:.0f}", value) : format_figure(value, 2);
  }
  if (const std::size_t star = format.find('*'); star != std::string_view::npos)
    value *= number_of(cut(format, "*"), "the factor");
  try {
    return fmt::format(fmt::runtime(fmt::format("{{:{}}}", trimmed(format))), value);
  } catch (const fmt::format_error&) {
    throw Error(fmt::format("the notation '{}'; expected a format of {{fmt}} such as .2f", trimmed(format)));
  }
}

std::string figure_of(std::string_view marker, const TableSource& tables) {
  std::string_view format = marker, figures = cut(format, "] as ");
  const std::string text = std::string(figures) + (format.empty() ? "" : "]");
  figures = text;
  const std::string_view first = cut(figures, "] /");
  if (figures.empty()) return notation(value_of(first, tables), trimmed(format));
  return notation(value_of(std::string(first) + "]", tables) / value_of(figures, tables), trimmed(format));
}

}  // namespace

std::string fill_quotes(const std::string& file, std::string_view text, const TableSource& tables) {
  std::string filled;
  std::size_t done = 0;
  for (std::size_t at; (at = text.find(opening, done)) != std::string_view::npos;) {
    const Location where = location_at(file, text, at);
    const std::size_t close = text.find(closing, at), end = text.find(end_mark, at);
    if (end == std::string_view::npos || text.find(opening, at + 1) < end)
      throw Error(where, fmt::format("a figure without its end; expected {}", end_mark));
    filled += text.substr(done, close + closing.size() - done);
    try {
      filled += figure_of(trimmed(text.substr(at + opening.size(), close - at - opening.size())), tables);
    } catch (const Error& e) {
      throw Error(where, e.what());
    }
    filled += end_mark;
    done = end + end_mark.size();
  }
  return filled + std::string(text.substr(done));
}

}  // namespace etendue
