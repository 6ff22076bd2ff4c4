#include "experiments/report/table_format.h"

#include "experiments/report/report_text.h"
#include "framework/core/check.h"
#include "framework/core/lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace etendue {
namespace {

std::string markdown_group(const Table& table, std::size_t group) {
  const auto columns = visible_columns(table, group);
  std::vector<std::size_t> widths;
  for (const std::size_t c : columns) {
    widths.push_back(std::max<std::size_t>(3, display_width(escape_markdown(table.columns[c].title))));
    for (const auto& row : table.rows) widths.back() = std::max(widths.back(), display_width(escape_markdown(row[c].text)));
  }
  // Padding helps where a line fits on a wide screen.
  constexpr std::size_t screen = 200;
  if (std::accumulate(widths.begin(), widths.end(), 3 * widths.size()) > screen) std::ranges::fill(widths, std::size_t{3});
  std::string out;
  const auto add_line = [&](const auto& text) {
    out += "|";
    for (std::size_t i = 0; i < columns.size(); ++i)
      out += " " + padded(text(i), widths[i], table.columns[columns[i]].right) + " |";
    out += "\n";
  };
  add_line([&](std::size_t i) { return escape_markdown(table.columns[columns[i]].title); });
  add_line([&](std::size_t i) {
    return table.columns[columns[i]].right ? std::string(widths[i] - 1, '-') + ":" : std::string(widths[i], '-');
  });
  for (const auto& row : table.rows) add_line([&](std::size_t i) { return escape_markdown(row[columns[i]].text); });
  return out;
}

std::string tex_group(const Table& table, std::size_t group, const std::string& title) {
  const auto columns = visible_columns(table, group);
  std::string spec, body;
  std::vector<std::string> heads;
  for (const std::size_t c : columns) {
    std::size_t longest = 0;
    for (const auto& row : table.rows) longest = std::max(longest, display_width(row[c].text));
    spec += table.columns[c].right ? "r" : longest <= 48 ? "l" : "p{0.4\\linewidth}";
    heads.push_back(escape_tex(table.columns[c].title));
  }
  for (const auto& row : table.rows) {
    std::vector<std::string> cells;
    for (const std::size_t c : columns) {
      cells.push_back(escape_tex(row[c].text));
      // A leading "[" would be read as the option of the \\ before it.
      if (cells.back().starts_with('[') || cells.back().starts_with('*')) cells.back().insert(0, "{}");
    }
    body += fmt::format("    {} \\\\\n", fmt::join(cells, " & "));
  }
  return fmt::format(
      "\\begin{{table}}\n  \\centering\\small\n  \\caption{{{}}}\n  \\label{{tab:{}}}\n"
      "  \\begin{{adjustbox}}{{max width=\\linewidth}}\n  \\begin{{tabular}}{{{}}}\n    "
      "\\toprule\n    {} \\\\\n    \\midrule\n{}    \\bottomrule\n  \\end{{tabular}}\n  \\end{{adjustbox}}\n\\end{{table}}\n",
      escape_tex(title), group == all_groups ? table.name : fmt::format("{}-{}", table.name, group), spec,
      fmt::join(heads, " & "), body);
}

// The columns of a page's table with the group that folds each; what is in group 0 is always shown.
struct Folds {
  static constexpr std::size_t widest = 9, kept = 7;  // columns

  explicit Folds(const Table& table) : titles(table.group_titles) {
    const auto visible = visible_columns(table);
    const bool cut = titles.empty() && visible.size() > widest;
    for (std::size_t i = 0; i < visible.size(); ++i)
      columns.emplace_back(visible[i], cut ? i >= kept : table.columns[visible[i]].group);
    if (cut) titles.push_back(fmt::format("{} more columns", visible.size() - kept));
    only_one = cut;
  }
  bool is_folded(std::size_t group) const { return group > 1 || only_one; }
  std::string chips() const {
    if (titles.empty()) return {};
    std::string out = "<div class=\"chips\" role=\"group\" aria-label=\"Columns\">";
    for (std::size_t g = 1; g < titles.size() + 1; ++g)
      if (std::ranges::any_of(columns, [&](const auto& column) { return column.second == g; }))
        out += fmt::format("<button type=\"button\" value=\"{}\" aria-pressed=\"{}\">{}</button>", g, !is_folded(g),
                           escape_html(titles[g - 1]));
    return out + "</div>";
  }

  std::vector<std::pair<std::size_t, std::size_t>> columns;  // of the table, group
  std::vector<std::string> titles;                           // of groups 1, 2, …
  bool only_one = false;
};

}  // namespace

TableCell::TableCell(double value) : TableCell(value, format_figure(value)) {}
TableCell::TableCell(double value, std::string shown) : TableCell(std::move(shown), fmt::format("{}", value), value) {}
TableCell times_cell(double factor) {
  return std::isfinite(factor) ? TableCell(factor, format_factor(factor) + "x") : TableCell("no image");
}

TableCell TableCell::interval(double value, double low, double high) {
  return {value, fmt::format("{} ({})", format_figure(value), format_interval(low, high))};
}

TableCell TableCell::ordered(const std::string& words, std::optional<double> by) {
  TableCell cell(words);
  if (by && std::isfinite(*by)) cell.order = by;
  return cell;
}

TableCell TableCell::positive(double value, std::string (*format)(double)) {
  return value > 0 ? TableCell(value, format) : TableCell();
}

std::vector<std::size_t> visible_columns(const Table& table, std::size_t group) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const TableColumn& column = table.columns[i];
    const bool in_group = group == all_groups || column.group == 0 || column.group == group;
    const auto is_filled = [&](const auto& row) { return !row[i].raw.empty() || row[i].text != TableCell().text; };
    const bool is_shown = table.rows.empty() || std::ranges::any_of(table.rows, is_filled);
    if (in_group && is_shown && column.audience != Audience::machines) chosen.push_back(i);
  }
  return chosen;
}

std::optional<std::size_t> column_of(const Table& table, std::string_view key) {
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (table.columns[i].audience != Audience::people && table.columns[i].key == key) return i;
  return std::nullopt;
}

void check_shape(const Table& table) {
  for (const auto& row : table.rows) CHECK_EQ(row.size(), table.columns.size());
}

std::string to_markdown(const Table& table) {
  check_shape(table);
  std::string out = fmt::format("# {}\n\n", table.title);
  if (table.rows.empty()) {
    out += "None.\n";
  } else if (table.group_titles.empty()) {
    out += markdown_group(table, all_groups);
  } else {
    for (std::size_t g = 0; g < table.group_titles.size(); ++g)
      out += fmt::format("{}## {}\n\n{}", g > 0 ? "\n" : "", table.group_titles[g], markdown_group(table, g + 1));
  }
  if (!table.notes.empty()) out += "\n";
  for (const std::string& note : table.notes) out += "- " + escape_markdown(note) + "\n";
  return out;
}

std::string to_csv(const Table& table) {
  check_shape(table);
  std::string out;
  const auto add_line = [&](const auto& text) {
    std::vector<std::string> fields;
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      if (table.columns[c].audience != Audience::people) fields.push_back(escape_csv(text(c)));
    out += fmt::format("{}\n", fmt::join(fields, ","));
  };
  add_line([&](std::size_t c) { return table.columns[c].key; });
  for (const auto& row : table.rows) add_line([&](std::size_t c) { return row[c].raw; });
  return out;
}

std::string to_tex(const Table& table) {
  check_shape(table);
  std::string out = "% needs \\usepackage{booktabs,adjustbox}\n";
  if (table.rows.empty()) return out + "% " + table.title + ": none.\n";
  if (table.group_titles.empty()) {
    out += tex_group(table, all_groups, table.title);
  } else {
    for (std::size_t g = 0; g < table.group_titles.size(); ++g)
      out += (g > 0 ? "\n" : "") + tex_group(table, g + 1, table.title + ": " + table.group_titles[g]);
  }
  for (const std::string& note : table.notes) {
    std::string line = note;
    std::ranges::replace(line, '\n', ' ');
    out += "% " + line + "\n";
  }
  return out;
}

std::string to_html(const Table& table, const std::string& csv) {
  std::string classes = "table";
  const Folds folds(table);
  for (std::size_t g = 1; g < folds.titles.size() + 1; ++g)
    if (folds.is_folded(g)) classes += fmt::format(" fold{}", g);
  return fmt::format("<figure class=\"{}\" id=\"table-{}\">{}</figure>\n", classes, escape_html(table.name),
                     table_html(table, csv));
}

std::string table_html(const Table& table, const std::string& csv) {
  check_shape(table);
  std::string out = fmt::format("<figcaption><span>{}</span>{}</figcaption>\n", escape_html(table.title),
                                csv.empty() ? "" : fmt::format("<a href=\"{}\">CSV</a>", escape_html(csv)));
  if (table.rows.empty()) return out + "<p class=\"none\">None.</p>";
  const Folds folds(table);
  out += folds.chips();
  out += "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>";
  bool names = true;  // the columns before the first figure
  for (const auto& [c, group] : folds.columns) {
    names = names && !table.columns[c].right;
    out += fmt::format("<th scope=\"col\" class=\"g{}{}{}\"><button type=\"button\">{}</button></th>", group,
                       table.columns[c].right ? " num" : "", names ? " names" : "", escape_html(table.columns[c].title));
  }
  out += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (const auto& [c, group] : folds.columns) {
      // Names stay on one line; only sentences wrap.
      const bool short_text = display_width(row[c].text) <= 40;
      out += fmt::format("<td class=\"g{}{}\"", group, table.columns[c].right ? " num" : short_text ? " name" : "");
      if (row[c].order) out += fmt::format(" data-v=\"{}\"", *row[c].order);
      out += ">" + escape_html(row[c].text) + "</td>";
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n" + notes_html(table.notes);
}

std::string notes_html(const std::vector<std::string>& notes) {
  const auto item = [](const std::string& note) { return "<li>" + escape_html(note) + "</li>"; };
  return notes.empty() ? "" : "<ul class=\"notes\">" + joined(notes, "", item) + "</ul>";
}

void add_column(Table& table, std::string&& key, std::string&& title, bool right, Audience audience, std::size_t group) {
  table.columns.push_back({std::move(key), std::move(title), right, audience, group});
}

void add_cell(Table& table, std::size_t row, TableCell cell) { table.rows[row].push_back(std::move(cell)); }

}  // namespace etendue
