#include "experiments/kinds/claims/claims_report.h"

#include "experiments/report/report_text.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace etendue {
namespace {

std::string figure_text(FigureKind kind, double value) {
  if (std::isinf(value)) return "∞";
  if (kind == FigureKind::time) return format_seconds(value);
  return format_figure(value) + (kind == FigureKind::factor ? "×" : "");
}

std::string measured_text(const ClaimFigure& figure) {
  const Measured& value = figure.value;
  std::string text = figure_text(figure.kind, value.median);
  if (value.low < value.high)
    text += fmt::format(" ({}–{})", figure_text(figure.kind, value.low), figure_text(figure.kind, value.high));
  return text;
}

std::string expected_text(const ClaimFigure& figure) {
  if (!figure.judged) return "–";
  const std::string low = figure_text(figure.kind, figure.expected_low), high = figure_text(figure.kind, figure.expected_high);
  if (std::isinf(figure.expected_high)) return "above " + low;
  if (std::isinf(figure.expected_low) || (figure.expected_low == 0 && figure.kind != FigureKind::plain)) return "below " + high;
  return figure.expected_low == figure.expected_high ? low : low + "–" + high;
}

// "builtin:mesh?triangles=100k" is known well enough as "mesh?triangles=100k".
std::string short_scene(const std::string& scene) {
  const std::size_t colon = scene.find(':');
  return colon == std::string::npos ? scene : scene.substr(colon + 1);
}

struct Judged {
  const ClaimRecord* record;
  const ClaimFigure* figure;
  ClaimVerdict verdict;
};

std::vector<Judged> judged_figures(const std::vector<const ClaimRecord*>& records) {
  std::vector<Judged> judged;
  for (const ClaimRecord* record : records)
    for (const ClaimFigure& figure : record->figures)
      if (figure.judged) judged.push_back({record, &figure, judge(figure)});
  return judged;
}

// "quantity on scene, scene" of some judged figures: the quantity only where there are several, the scenes only where not all
// of them are meant.
std::string name_figures(const std::vector<Judged>& some, const std::vector<Judged>& all) {
  std::set<std::string> texts, done;
  for (const Judged& j : all) texts.insert(j.figure->text);
  std::string names;
  for (const Judged& j : some) {
    const std::string& text = j.figure->text;
    if (!done.insert(text).second) continue;
    const auto same = [&](const Judged& other) { return other.figure->text == text; };
    std::string scenes;
    for (const Judged& other : some)
      if (same(other)) scenes += (scenes.empty() ? "" : ", ") + short_scene(other.record->cell.scene);
    const bool everywhere = std::count_if(some.begin(), some.end(), same) == std::count_if(all.begin(), all.end(), same);
    if (!names.empty()) names += "; ";
    if (texts.size() > 1) names += everywhere ? text : text + " on ";
    if (!everywhere) names += scenes;
  }
  return names;
}

std::string describe_split(const std::vector<Judged>& judged) {
  std::vector<std::pair<ClaimVerdict, std::vector<Judged>>> groups;
  for (const Judged& j : judged) {
    auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first == j.verdict; });
    if (found == groups.end()) found = groups.insert(found, {j.verdict, {}});
    found->second.push_back(j);
  }
  std::string text;
  for (const auto& [verdict, some] : groups)
    text += fmt::format("{}{}: {}", text.empty() ? "" : " | ", verdict_name(verdict), name_figures(some, judged));
  return text;
}

// "quantity: 1.2× (1.1–1.3) on scene, 1.4× … on scene", one for each quantity.
std::vector<std::string> describe_measured(const std::vector<Judged>& judged) {
  std::set<std::string> scenes;
  std::vector<std::string> texts, lines;
  for (const Judged& j : judged) {
    scenes.insert(j.record->cell.scene);
    if (std::find(texts.begin(), texts.end(), j.figure->text) == texts.end()) texts.push_back(j.figure->text);
  }
  for (const std::string& text : texts) {
    std::string line;
    for (const Judged& j : judged) {
      if (j.figure->text != text) continue;
      line += (line.empty() ? "" : ", ") + measured_text(*j.figure);
      if (scenes.size() > 1) line += " on " + short_scene(j.record->cell.scene);
    }
    lines.push_back(text + ": " + line);
  }
  return lines;
}

// What the claim's words were taken to mean, and what its measurements remark; each once.
std::string remarks_of(const ClaimFindings& claim) {
  std::vector<std::string> parts;
  const auto add = [&](const std::string& part) {
    if (!part.empty() && std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
  };
  for (const ClaimRecord* record : claim.records) add(record->reading);
  for (const ClaimRecord* record : claim.records)
    for (const std::string& remark : record->remarks) add(remark);
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : " ") + part;
  return text;
}

std::string summarise_verdicts(const std::vector<ClaimFindings>& claims) {
  std::map<ClaimVerdict, int> counts;
  for (const ClaimFindings& claim : claims) ++counts[claim.verdict];
  std::string text;
  for (const auto& [verdict, count] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, verdict_name(verdict));
  return text;
}

TableCell words_or_none(const std::string& text) { return text.empty() ? TableCell{} : TableCell::words(text); }

std::string verdict_text(const ClaimFindings& claim) {
  return std::string(verdict_name(claim.verdict)) + (claim.on_what.empty() ? "" : " (" + claim.on_what + ")");
}

constexpr const char* rule =
    "Measured: medians of interleaved repetitions, with their quartiles. Confirmed: the quartiles meet the claimed interval; "
    "weaker or stronger: an effect of the claimed direction, but less or more (a shorter time is more); refuted: no effect "
    "beyond "
    "the spread, or the opposite one; undecided: the spread reaches from no effect into the claim; of a claim of little "
    "effect, or "
    "of a count, the median must lie in the interval; depends: figures or scenes differ, as said behind it.";

}  // namespace

std::vector<ClaimFindings> arrange_claims(const RunLog& log) {
  std::map<int, std::vector<const ClaimRecord*>> by_id;
  for (const ClaimRecord* record : records_of<ClaimRecord>(log))
    if (record->done()) by_id[record->id].push_back(record);
  std::vector<ClaimFindings> claims;
  for (auto& [id, records] : by_id) {
    const std::vector<Judged> judged = judged_figures(records);
    if (judged.empty()) continue;
    std::vector<ClaimVerdict> verdicts;
    for (const Judged& j : judged) verdicts.push_back(j.verdict);
    ClaimFindings claim{id, std::move(records), combine(verdicts), {}, describe_measured(judged)};
    if (claim.verdict == ClaimVerdict::depends) claim.on_what = describe_split(judged);
    claims.push_back(std::move(claim));
  }
  return claims;
}

Table claims_table(const RunLog& log) {
  Table table{"claims", "Textbook statements, measured", {}, {}, {}, {}};
  table.columns = {{"id", "#"},
                   {"claim", "claim", false},
                   {"source", "source", false},
                   {"claimed", "claimed", false},
                   {"measured", "measured", false},
                   {"verdict", "verdict", false},
                   {"depends_on", "depends on", false},
                   {"remarks", "remarks", false}};
  for (const ClaimFindings& claim : arrange_claims(log)) {
    const ClaimRecord& first = *claim.records.front();
    table.rows.push_back({TableCell::count(static_cast<std::uint64_t>(claim.id)), TableCell::words(first.claim),
                          TableCell::words(first.source), TableCell::words(first.claimed),
                          TableCell::words(fmt::format("{}", fmt::join(claim.measured, "; "))),
                          TableCell::words(std::string(verdict_name(claim.verdict))), words_or_none(claim.on_what),
                          words_or_none(remarks_of(claim))});
  }
  if (!table.rows.empty()) table.notes.push_back(rule);
  for (std::string& line : failed_cells<ClaimRecord>(log)) table.notes.push_back(std::move(line));
  return table;
}

Table claim_figures_table(const RunLog& log) {
  Table table{"claim-figures", "Textbook statements: every figure", {}, {}, {}, {}};
  table.columns = {{"id", "#"},
                   {"measure", "measurement", false},
                   {"scene", "scene", false},
                   {"quantity", "", false, Audience::machines},
                   {"text", "quantity", false},
                   {"expected", "claimed", false, Audience::people},
                   {"expected_low", "", true, Audience::machines},
                   {"expected_high", "", true, Audience::machines},
                   {"measured", "measured", false, Audience::people},
                   {"median", "", true, Audience::machines},
                   {"low", "", true, Audience::machines},
                   {"high", "", true, Audience::machines},
                   {"verdict", "verdict", false}};
  for (const ClaimRecord* logged : records_of<ClaimRecord>(log)) {
    const ClaimRecord& record = *logged;
    if (!record.done()) continue;
    for (const ClaimFigure& figure : record.figures) {
      const auto end = [&](double value) {
        return figure.judged && std::isfinite(value) ? TableCell::number(value) : TableCell{};
      };
      table.rows.push_back({TableCell::count(static_cast<std::uint64_t>(record.id)), TableCell::words(record.cell.accel),
                            TableCell::words(record.cell.scene), TableCell::words(figure.quantity),
                            TableCell::words(figure.text), TableCell::words(expected_text(figure)), end(figure.expected_low),
                            end(figure.expected_high), TableCell::words(measured_text(figure)),
                            TableCell::number(figure.value.median), TableCell::number(figure.value.low),
                            TableCell::number(figure.value.high),
                            figure.judged ? TableCell::words(std::string(verdict_name(judge(figure)))) : TableCell{}});
    }
  }
  std::stable_sort(table.rows.begin(), table.rows.end(),
                   [](const auto& a, const auto& b) { return a[0].order.value_or(0) < b[0].order.value_or(0); });
  if (!table.rows.empty())
    table.notes.push_back("Figures without a verdict are not claimed; they stand beside to be compared.");
  return table;
}

KindReport claims_report(const RunLog& log) {
  if (records_of<ClaimRecord>(log).empty()) return {};
  const std::vector<ClaimFindings> claims = arrange_claims(log);
  KindReport report{.tables = {claims_table(log), claim_figures_table(log)},
                    .id = "claims",
                    .heading = "Textbook statements, measured",
                    .finds_in_section = true};
  if (!claims.empty()) report.fact = fmt::format("{} {}", claims.size(), claims.size() == 1 ? "statement" : "statements");
  report.answer = fmt::format("{} statements: {}.", claims.size(), summarise_verdicts(claims));
  std::string& out = report.section;
  out = fmt::format("<p>{}</p>\n<p class=\"note\">{}</p>\n", escape_html(report.answer), escape_html(rule));
  out += "<div class=\"findings\">\n";
  for (const ClaimFindings& claim : claims) {
    const ClaimRecord& first = *claim.records.front();
    out +=
        fmt::format("<article class=\"card\"><h3>{}. {}</h3><dl><dt>claimed</dt><dd>{} <span class=\"note\">({})</span></dd>",
                    claim.id, escape_html(first.claim), escape_html(first.claimed), escape_html(first.source));
    out += fmt::format("<dt>verdict</dt><dd><strong>{}</strong>{}</dd><dt>measured</dt><dd><ul>", verdict_name(claim.verdict),
                       claim.on_what.empty() ? "" : ": " + escape_html(claim.on_what));
    for (const std::string& line : claim.measured) out += "<li>" + escape_html(line) + "</li>";
    out += "</ul></dd></dl>";
    if (const std::string remarks = remarks_of(claim); !remarks.empty())
      out += fmt::format("<p class=\"note\">{}</p>", escape_html(remarks));
    out += "</article>\n";
  }
  out += "</div>\n";
  for (const std::string& line : failed_cells<ClaimRecord>(log)) out += "<p>" + escape_html(line) + "</p>\n";
  return report;
}

std::string claims_summary(const RunLog& log) {
  const std::vector<ClaimFindings> claims = arrange_claims(log);
  std::string out;
  for (const ClaimFindings& claim : claims) {
    const ClaimRecord& first = *claim.records.front();
    out += fmt::format("{:2}  {}\n      claimed {}; measured {}\n      {}\n", claim.id, first.claim, first.claimed,
                       fmt::join(claim.measured, "; "), verdict_text(claim));
  }
  out += claims.empty()
             ? "The log holds no finished claim.\n"
             : fmt::format("{} statement{}: {}\n", claims.size(), claims.size() == 1 ? "" : "s", summarise_verdicts(claims));
  for (const std::string& line : failed_cells<ClaimRecord>(log)) out += line + "\n";
  return out;
}

}  // namespace etendue
