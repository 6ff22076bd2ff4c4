#include "experiments/kinds/stress/stress_report.h"

#include "experiments/report/report_text.h"
#include "framework/core/check.h"

#include <fmt/format.h>
#include <map>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

namespace etendue {

namespace {

bool within(double value, double low, double high) { return low <= value && value <= high; }

double distance(double value, double low, double high) { return std::max({0.0, low - value, value - high}); }

std::string interval_text(double low, double high) {
  if (std::isinf(high)) return "above " + format_figure(low);
  if (std::isinf(low)) return "below " + format_figure(high);
  return fmt::format("{} to {}", format_figure(low), format_figure(high));
}

std::string measured_text(const Measured& value) {
  std::string text = format_figure(value.median);
  if (value.low < value.high) text += fmt::format(" ({} to {})", format_figure(value.low), format_figure(value.high));
  return text;
}

constexpr const char* rule =
    "Measured: the median over seeds, with its quartiles. A method fails as expected where its figure lies where the failure "
    "is "
    "expected to bring it, and holds where it lies in the interval of a method that does not fail. A remedy holds likewise; it "
    "helps where it has brought the figure at least half of the way.";

std::string embedded_picture(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  return bytes.empty() ? std::string() : base64(bytes);
}

}  // namespace

std::string_view verdict_name(StressVerdict verdict) {
  constexpr std::string_view names[] = {"fails as expected", "fails otherwise", "holds", "helps", "does not help"};
  return names[static_cast<int>(verdict)];
}

std::vector<StressVerdict> judge_stress(const StressRecord& record) {
  CHECK(!record.figures.empty());
  const double low = record.holds_low, high = record.holds_high;
  const ClaimFigure& first = record.figures.front();
  const double failing = first.value.median;
  std::vector<StressVerdict> verdicts;
  if (within(failing, low, high))
    verdicts.push_back(StressVerdict::holds);
  else
    verdicts.push_back(within(failing, first.expected_low, first.expected_high) ? StressVerdict::fails_as_expected
                                                                                : StressVerdict::fails_otherwise);
  for (std::size_t i = 1; i < record.figures.size(); ++i) {
    const double left = distance(record.figures[i].value.median, low, high);
    verdicts.push_back(left == 0                                    ? StressVerdict::holds
                       : left <= 0.5 * distance(failing, low, high) ? StressVerdict::helps
                                                                    : StressVerdict::no_help);
  }
  return verdicts;
}

std::vector<const StressRecord*> arrange_stress(const RunLog& log) {
  std::vector<const StressRecord*> rows = records_of<StressRecord>(log);
  std::erase_if(rows, [](const StressRecord* record) { return !record->done(); });
  std::stable_sort(rows.begin(), rows.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return rows;
}

Table stress_table(const RunLog& log) {
  Table table{"stress", "Methods on the scenes that break them", {}, {}, {}, {}};
  table.columns = {{"id", "#"},
                   {"failure", "failure", false},
                   {"source", "source", false},
                   {"scene", "scene", false},
                   {"figure", "figure", false},
                   {"method", "method", false},
                   {"remedy", "remedy", false},
                   {"expected", "expected", false},
                   {"measured", "measured", false, Audience::people},
                   {"median", "", true, Audience::machines},
                   {"low", "", true, Audience::machines},
                   {"high", "", true, Audience::machines},
                   {"verdict", "verdict", false}};
  for (const StressRecord* record : arrange_stress(log)) {
    const std::vector<StressVerdict> verdicts = judge_stress(*record);
    for (std::size_t i = 0; i < record->figures.size(); ++i) {
      const ClaimFigure& figure = record->figures[i];
      table.rows.push_back({TableCell::count(static_cast<std::uint64_t>(record->id)), TableCell::words(record->claim),
                            TableCell::words(record->source), TableCell::words(record->cell.scene),
                            TableCell::words(figure.text), TableCell::words(record->methods.at(i)),
                            i == 0 ? TableCell{} : TableCell::words(figure.quantity),
                            TableCell::words(interval_text(figure.expected_low, figure.expected_high)),
                            TableCell::words(measured_text(figure.value)), TableCell::number(figure.value.median),
                            TableCell::number(figure.value.low), TableCell::number(figure.value.high),
                            TableCell::words(std::string(verdict_name(verdicts[i])))});
    }
  }
  if (!table.rows.empty()) table.notes.push_back(rule);
  for (std::string& line : failed_cells<StressRecord>(log)) table.notes.push_back(std::move(line));
  return table;
}

namespace {

std::string counts_text(const std::map<std::string_view, std::size_t>& counts) {
  std::string text;
  for (const auto& [verdict, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, verdict);
  return text;
}

// "14 failures. Methods as they come: 14 fails. With a remedy: 3 fails, 5 helps, 18 holds."
std::string answer_of(const std::vector<const StressRecord*>& rows) {
  std::map<std::string_view, std::size_t> plain, remedied;
  for (const StressRecord* record : rows) {
    const std::vector<StressVerdict> verdicts = judge_stress(*record);
    for (std::size_t i = 0; i < verdicts.size(); ++i) ++(i == 0 ? plain : remedied)[verdict_name(verdicts[i])];
  }
  return fmt::format("{} failures. Methods as they come: {}. With a remedy: {}.", rows.size(), counts_text(plain),
                     counts_text(remedied));
}

}  // namespace

KindReport stress_report(const RunLog& log) {
  if (records_of<StressRecord>(log).empty()) return {};
  const std::vector<const StressRecord*> rows = arrange_stress(log);
  KindReport report{.tables = {stress_table(log)}, .id = "stress", .heading = "Where methods fail", .finds_in_section = true};
  if (!rows.empty()) report.fact = fmt::format("{} {}", rows.size(), rows.size() == 1 ? "failure" : "failures");
  report.answer = answer_of(rows);
  std::string& out = report.section;
  out = fmt::format("<p class=\"note\">{}</p>\n<div class=\"findings\">\n", escape_html(rule));
  for (const StressRecord* record : rows) {
    const std::vector<StressVerdict> verdicts = judge_stress(*record);
    out += fmt::format("<article class=\"card\"><h3>{}. {}</h3>", record->id, escape_html(record->claim));
    std::string caption = "reference";
    for (const ClaimFigure& figure : record->figures) caption += " | " + figure.quantity;
    if (const std::string png = embedded_picture(record->picture); !png.empty())
      out += fmt::format(
          "<figure><img style=\"width:100%\" alt=\"{0}\" "
          "src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
          escape_html(caption), png);
    out += fmt::format("<p class=\"note\">{}: {}; {}. Would hold: {}.</p><dl>", escape_html(record->cell.scene),
                       escape_html(record->claimed), escape_html(record->source),
                       interval_text(record->holds_low, record->holds_high));
    for (std::size_t i = 0; i < record->figures.size(); ++i) {
      const ClaimFigure& figure = record->figures[i];
      out += fmt::format("<dt>{}</dt><dd><strong>{}</strong>: {} <span class=\"note\">(expected {}; {})</span></dd>",
                         escape_html(figure.quantity), verdict_name(verdicts[i]), measured_text(figure.value),
                         interval_text(figure.expected_low, figure.expected_high), escape_html(record->methods.at(i)));
    }
    out += "</dl></article>\n";
  }
  out += "</div>\n";
  for (const std::string& line : failed_cells<StressRecord>(log)) out += "<p>" + escape_html(line) + "</p>\n";
  return report;
}

std::string stress_summary(const RunLog& log) {
  std::string out;
  for (const StressRecord* record : arrange_stress(log)) {
    const std::vector<StressVerdict> verdicts = judge_stress(*record);
    out += fmt::format("{:2}  {}  ({}: {})\n", record->id, record->claim, record->cell.scene, record->claimed);
    std::size_t widest = 16;
    for (const ClaimFigure& figure : record->figures) widest = std::max(widest, display_width(figure.quantity));
    for (std::size_t i = 0; i < record->figures.size(); ++i) {
      const ClaimFigure& figure = record->figures[i];
      const std::string found =
          fmt::format("{:<24} expected {:<14} {}", measured_text(figure.value),
                      interval_text(figure.expected_low, figure.expected_high), verdict_name(verdicts[i]));
      // A long name stands above its figures, so that a terminal's 100 columns hold both.
      if (const std::string line = fmt::format("      {:<{}} {}\n", figure.quantity, widest, found); display_width(line) <= 101)
        out += line;
      else
        out += fmt::format("      {}\n        {}\n", figure.quantity, found);
    }
  }
  if (out.empty()) out = "The log holds no finished row.\n";
  for (const std::string& line : failed_cells<StressRecord>(log)) out += line + "\n";
  return out;
}

}  // namespace etendue
