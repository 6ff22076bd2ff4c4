#include "experiments/kinds/stress/stress_report.h"

#include "experiments/report/report_text.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace etendue {

namespace {

double distance(double value, const Expected& interval) { return std::max({0.0, interval.low - value, value - interval.high}); }

constexpr const char* rule =
    "Failures: the median over seeds, with its quartiles; the median is judged. As it is, a method is expected to fail: "
    "refuted "
    "says that it does not. With a remedy it is expected to hold: weaker says that the remedy brings the figure more than half "
    "of the way.";

std::string embedded_picture(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  return bytes.empty() ? std::string() : base64(bytes);
}

// The rows that are done, by id.
std::vector<const StressRecord*> arrange_stress(const RunLog& log) {
  std::vector<const StressRecord*> rows = done_records_of<StressRecord>(log);
  std::ranges::stable_sort(rows, [](const auto* a, const auto* b) { return a->id < b->id; });
  return rows;
}

std::string name_of(const JudgedPrediction& row) { return row.remedy.empty() ? "as it is" : row.remedy; }

// "14 failures of methods as they come: 14 confirmed; with remedies: 12 confirmed, 9 weaker, 7 refuted."
std::string answer_of(const Predictions& predictions) {
  std::vector<Verdict> plain, remedied;
  for (const JudgedPrediction& row : predictions.rows) (row.remedy.empty() ? plain : remedied).push_back(*row.verdict);
  const std::string with = remedied.empty() ? "" : fmt::format("; with remedies: {}", count_verdicts(remedied));
  return fmt::format("{} failures of methods as they come: {}{}.", plain.size(), count_verdicts(plain), with);
}

}  // namespace

std::vector<JudgedPrediction> judge_stress(const StressRecord& record) {
  CHECK(!record.figures.empty());
  const Expected& holds = record.holds;
  const Expected& fails = record.figures.front().expected;
  const double failing = record.figures.front().value.median;
  std::vector<JudgedPrediction> rows;
  for (std::size_t i = 0; i < record.figures.size(); ++i) {
    const ClaimFigure& figure = record.figures[i];
    const double value = figure.value.median;
    JudgedPrediction& row = rows.emplace_back(JudgedPrediction{.id = record.id,
                                                               .statement = record.claim,
                                                               .scene = record.cell.scene,
                                                               .method = record.methods.at(i),
                                                               .remedy = i == 0 ? "" : figure.quantity,
                                                               .quantity = figure.text,
                                                               .source = record.source,
                                                               .kind = figure.kind,
                                                               .expected = figure.expected,
                                                               .value = value,
                                                               .interval = Interval{figure.value.low, figure.value.high}});
    const double left = distance(value, holds) == 0 ? 0 : distance(value, holds) / distance(failing, holds);
    row.verdict = i == 0 ? judge(value, {value, value}, fails, fails.low > holds.high ? holds.high : holds.low)
                         : judge(left, {left, left}, {0, 0}, 0.5);
  }
  return rows;
}

KindReport stress_report(const RunLog& log) {
  if (records_of<StressRecord>(log).empty()) return {};
  const std::vector<const StressRecord*> records = arrange_stress(log);
  KindReport report{.id = "stress", .heading = "Where methods fail"};
  if (!records.empty()) report.fact = counted(records.size(), "failure");
  std::string& out = report.section;
  out = fmt::format("<p class=\"note\">{} {}</p>\n<div class=\"findings\">\n", escape_html(rule), escape_html(verdict_rule));
  for (const StressRecord* record : records) {
    const std::vector<JudgedPrediction> rows = judge_stress(*record);
    report.predictions.rows.insert(report.predictions.rows.end(), rows.begin(), rows.end());
    out += fmt::format("<article class=\"card\"><h3>{}. {}</h3>", record->id, escape_html(record->claim));
    std::string caption = "reference";
    for (const JudgedPrediction& row : rows) caption += " | " + name_of(row);
    if (const std::string png = embedded_picture(record->picture); !png.empty())
      out += fmt::format(
          "<figure><img style=\"width:100%\" alt=\"{0}\" "
          "src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
          escape_html(caption), png);
    const JudgedPrediction sound{.scene = {}, .method = {}, .quantity = {}, .source = {}, .expected = record->holds};
    out += fmt::format("<p class=\"note\">{}: {}; {}. Would hold: {}.</p><dl>", escape_html(record->cell.scene),
                       escape_html(record->claimed), escape_html(record->source), sound.expected_text());
    for (const JudgedPrediction& row : rows)
      out += fmt::format("<dt>{}</dt><dd><strong>{}</strong>: {} <span class=\"note\">(expected {}; {})</span></dd>",
                         escape_html(name_of(row)), verdict_name(*row.verdict), row.measured_text(), row.expected_text(),
                         escape_html(row.method));
    out += "</dl></article>\n";
  }
  out += "</div>\n";
  for (const std::string& line : failed_cells<StressRecord>(log)) {
    report.predictions.notes.push_back(line);
    out += "<p>" + escape_html(line) + "</p>\n";
  }
  report.predictions.notes.insert(report.predictions.notes.begin(), rule);
  report.answer = answer_of(report.predictions);
  return report;
}

std::string stress_summary(const RunLog& log) {
  std::string out;
  for (const StressRecord* record : arrange_stress(log)) {
    const std::vector<JudgedPrediction> rows = judge_stress(*record);
    out += fmt::format("{:2}  {}  ({}: {})\n", record->id, record->claim, record->cell.scene, record->claimed);
    std::size_t widest = 16;
    for (const JudgedPrediction& row : rows) widest = std::max(widest, display_width(name_of(row)));
    for (const JudgedPrediction& row : rows) {
      const std::string found =
          fmt::format("{:<24} expected {:<14} {}", row.measured_text(), row.expected_text(), verdict_name(*row.verdict));
      // A long name stands above its figures, so that a terminal's 100 columns hold both.
      if (const std::string line = fmt::format("      {:<{}} {}\n", name_of(row), widest, found); display_width(line) <= 101)
        out += line;
      else
        out += fmt::format("      {}\n        {}\n", name_of(row), found);
    }
  }
  if (out.empty()) out = "The log holds no finished row.\n";
  for (const std::string& line : failed_cells<StressRecord>(log)) out += line + "\n";
  return out;
}

}  // namespace etendue
