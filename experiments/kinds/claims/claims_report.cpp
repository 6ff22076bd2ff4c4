#include "experiments/kinds/claims/claims.h"

#include "experiments/report/report_data.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {
namespace {

using Rows = std::vector<JudgedPrediction>;

JudgedPrediction row_of(const ClaimRecord& record, const ClaimFigure& figure) {
  JudgedPrediction row{.id = record.id,
                       .scene = record.cell.scene,
                       .method = record.cell.accel,
                       .quantity = figure.text,
                       .source = {},
                       .kind = figure.kind,
                       .expected = figure.judged ? std::optional(figure.expected) : std::nullopt};
  row.measure(figure.value.median, Interval{figure.value.low, figure.value.high});
  row.details = {{"figure", figure.quantity}};
  return row;
}

// "builtin:mesh?triangles=100k" is known well enough as "mesh?triangles=100k".
std::string short_scene(const std::string& scene) {
  const std::size_t colon = scene.find(':');
  return colon == std::string::npos ? scene : scene.substr(colon + 1);
}

std::vector<std::string> quantities_of(const Rows& rows) {
  std::vector<std::string> quantities;
  for (const JudgedPrediction& row : rows) index_in(quantities, row.quantity);
  return quantities;
}

// "quantity on scene, scene" of some of the rows: the quantity only where there are several, the scenes only where not all of
// them are meant.
std::string name_rows(const Rows& some, const Rows& all) {
  std::string names;
  for (const std::string& quantity : quantities_of(some)) {
    const auto same = [&](const JudgedPrediction& row) { return row.quantity == quantity; };
    const std::string scenes =
        joined(some | std::views::filter(same), ", ", [](const JudgedPrediction& row) { return short_scene(row.scene); });
    const bool everywhere = std::ranges::count_if(some, same) == std::ranges::count_if(all, same);
    if (!names.empty()) names += "; ";
    if (quantities_of(all).size() > 1) names += everywhere ? quantity : quantity + " on ";
    if (!everywhere) names += scenes;
  }
  return names;
}

// Writes "confirmed: … | refuted: …", in the order of the rows.
std::string describe_split(const Rows& rows) {
  std::vector<std::pair<Verdict, Rows>> groups;
  for (const JudgedPrediction& row : rows) {
    const auto same = [&](const auto& group) { return group.first == *row.verdict; };
    find_or_add(groups, same, {*row.verdict, {}}).second.push_back(row);
  }
  return joined(groups, " | ", [&](const auto& group) {
    return fmt::format("{}: {}", verdict_name(group.first), name_rows(group.second, rows));
  });
}

// Writes "quantity: 1.2× (1.1×–1.3×) on scene, 1.4× … on scene" for each quantity.
std::vector<std::string> describe_measured(const Rows& rows) {
  std::set<std::string> scenes;
  for (const JudgedPrediction& row : rows) scenes.insert(row.scene);
  const auto measured = [&](const JudgedPrediction& row) {
    return row.measured_text() + (scenes.size() > 1 ? " on " + short_scene(row.scene) : "");
  };
  return mapped(quantities_of(rows), [&](const std::string& quantity) {
    const auto is_its = [&](const JudgedPrediction& row) { return row.quantity == quantity; };
    return quantity + ": " + joined(rows | std::views::filter(is_its), ", ", measured);
  });
}

// Says what the claim's words were taken to mean, and what its measurements remark; each once.
std::string remarks_of(const ClaimFindings& claim) {
  std::vector<std::string> parts;
  for (const ClaimRecord* record : claim.records)
    if (!record->reading.empty()) index_in(parts, record->reading);
  for (const ClaimRecord* record : claim.records)
    for (const std::string& remark : record->remarks) index_in(parts, remark);
  return joined(parts, " ");
}

// "27 statements: 6 confirmed, 15 depends".
std::string count_claims(const std::vector<ClaimFindings>& claims) {
  return fmt::format("{}: {}", counted(claims.size(), "statement"), count_verdicts(mapped(claims, &ClaimFindings::verdict)));
}

Predictions claim_predictions(const RunLog& log) {
  Predictions predictions;
  for (const ClaimRecord* record : done_records_of<ClaimRecord>(log))
    for (const ClaimFigure& figure : record->figures) predictions.rows.push_back(row_of(*record, figure));
  if (!predictions.rows.empty())
    predictions.notes.push_back(
        "Statements: medians of interleaved repetitions, with their quartiles. Figures without a verdict are not claimed; they "
        "stand beside to be compared.");
  return predictions;
}

}  // namespace

std::vector<ClaimFindings> arrange_claims(const RunLog& log) {
  std::map<int, std::vector<const ClaimRecord*>> by_id;
  for (const ClaimRecord* record : done_records_of<ClaimRecord>(log)) by_id[record->id].push_back(record);
  std::vector<ClaimFindings> claims;
  for (auto& [id, records] : by_id) {
    Rows rows;
    std::vector<Verdict> verdicts;
    for (const ClaimRecord* record : records)
      for (const ClaimFigure& figure : record->figures) {
        if (!figure.judged) continue;
        rows.push_back(row_of(*record, figure));
        verdicts.push_back(*rows.back().verdict);
      }
    if (rows.empty()) continue;
    ClaimFindings claim{id, std::move(records), combine(verdicts), {}, describe_measured(rows)};
    if (claim.verdict == Verdict::depends) claim.on_what = describe_split(rows);
    claims.push_back(std::move(claim));
  }
  return claims;
}

Table claims_table(const RunLog& log) {
  TableOf<ClaimFindings> table("claims", "Textbook statements, measured", arrange_claims(log));
  table.column("id", "#", &ClaimFindings::id);
  table.column("claim", "claim", [](const ClaimFindings& claim) { return claim.stated().claim; });
  table.column("source", "source", [](const ClaimFindings& claim) { return claim.stated().source; });
  table.column("claimed", "claimed", [](const ClaimFindings& claim) { return claim.stated().claimed; });
  table.column("measured", "measured", [](const ClaimFindings& claim) { return joined(claim.measured, "; "); });
  table.column("verdict", "verdict", [](const ClaimFindings& claim) { return std::string(verdict_name(claim.verdict)); });
  table.column("depends_on", "depends on", &ClaimFindings::on_what);
  table.column("remarks", "remarks", remarks_of);
  table.note(fmt::format("{} Depends: figures or scenes differ, as said behind it.", verdict_rule));
  return table.take(failed_cells<ClaimRecord>(log));
}

KindReport claims_report(const RunLog& log) {
  if (records_of<ClaimRecord>(log).empty()) return {};
  const std::vector<ClaimFindings> claims = arrange_claims(log);
  KindReport report{.tables = {claims_table(log)},
                    .predictions = claim_predictions(log),
                    .answer = count_claims(claims) + ".",
                    .id = "claims",
                    .heading = "Textbook statements, measured"};
  if (!claims.empty()) report.fact = counted(claims.size(), "statement");
  std::string& out = report.section;
  out = fmt::format("<p>{}</p>\n<p class=\"note\">{}</p>\n", escape_html(report.answer), escape_html(verdict_rule));
  out += "<div class=\"findings\">\n";
  for (const ClaimFindings& claim : claims) {
    const ClaimRecord& first = claim.stated();
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
    const ClaimRecord& first = claim.stated();
    out += fmt::format("{:2}  {}\n      claimed {}; measured {}\n      {}{}\n", claim.id, first.claim, first.claimed,
                       fmt::join(claim.measured, "; "), verdict_name(claim.verdict),
                       claim.on_what.empty() ? "" : " (" + claim.on_what + ")");
  }
  out += claims.empty() ? "The log holds no finished claim.\n" : count_claims(claims) + "\n";
  for (const std::string& line : failed_cells<ClaimRecord>(log)) out += line + "\n";
  return out;
}

}  // namespace etendue
