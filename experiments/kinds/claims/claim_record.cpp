#include "experiments/kinds/claims/claim_record.h"

#include "experiments/log/json_line.h"

#include <cmath>
#include <limits>

namespace etendue {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr const char* kind_names[] = {"factor", "time", "plain"};

Json to_json(const ClaimFigure& figure) {
  Json json{{"quantity", figure.quantity},
            {"text", figure.text},
            {"kind", kind_names[static_cast<int>(figure.kind)]},
            {"median", finite(figure.value.median)},
            {"low", finite(figure.value.low)},
            {"high", finite(figure.value.high)},
            {"judged", figure.judged}};
  // JSON knows no infinity: an open end has no key.
  if (figure.judged && std::isfinite(figure.expected_low)) json["expected_low"] = figure.expected_low;
  if (figure.judged && std::isfinite(figure.expected_high)) json["expected_high"] = figure.expected_high;
  return json;
}

ClaimFigure read_figure(const Json& json) {
  ClaimFigure figure;
  figure.quantity = json.at("quantity");
  figure.text = json.at("text");
  const std::string kind = json.at("kind");
  for (int i = 0; i < 3; ++i)
    if (kind == kind_names[i]) figure.kind = static_cast<FigureKind>(i);
  figure.value = {json.at("median"), json.at("low"), json.at("high")};
  figure.judged = json.at("judged");
  if (figure.judged) {
    figure.expected_low = json.value("expected_low", -endless);
    figure.expected_high = json.value("expected_high", endless);
  }
  return figure;
}

}  // namespace

std::string to_json_line(const ClaimRecord& r) {
  Json figures = Json::array();
  for (const ClaimFigure& figure : r.figures) figures.push_back(to_json(figure));
  Json json{{"type", "claim"},           {"id", r.id},
            {"scene", r.cell.scene},     {"measure", r.cell.accel},
            {"cell", r.cell.integrator}, {"seed", r.cell.seed},
            {"manifest", r.manifest},    {"status", r.status},
            {"error", r.error},          {"claim", r.claim},
            {"source", r.source},        {"claimed", r.claimed},
            {"reading", r.reading},      {"figures", std::move(figures)},
            {"remarks", r.remarks},      {"disagreements", r.disagreements}};
  if (const auto& stress = r.stress) {
    json["stress"] = {{"methods", stress->methods},
                      {"picture", stress->picture},
                      {"picture_bytes", stress->picture_stamp.bytes},
                      {"picture_xxh3", stress->picture_stamp.hash}};
    if (std::isfinite(stress->holds_low)) json["stress"]["holds_low"] = stress->holds_low;
    if (std::isfinite(stress->holds_high)) json["stress"]["holds_high"] = stress->holds_high;
  }
  return dump(json);
}

ClaimRecord read_claim_line(const std::string& line) {
  const Json json = Json::parse(line);
  ClaimRecord r;
  r.id = json.at("id");
  r.cell = {json.at("scene"), json.at("measure"), json.at("cell"), json.at("seed").get<std::uint64_t>()};
  r.manifest = json.at("manifest");
  r.status = json.at("status");
  r.error = json.at("error");
  r.claim = json.at("claim");
  r.source = json.at("source");
  r.claimed = json.at("claimed");
  r.reading = json.at("reading");
  for (const Json& figure : json.at("figures")) r.figures.push_back(read_figure(figure));
  r.remarks = json.at("remarks").get<std::vector<std::string>>();
  r.disagreements = json.at("disagreements");
  if (const auto stress = json.find("stress"); stress != json.end())
    r.stress = {stress->value("holds_low", -endless),
                stress->value("holds_high", endless),
                stress->at("methods").get<std::vector<std::string>>(),
                stress->at("picture").get<std::string>(),
                {stress->value("picture_bytes", std::uint64_t{0}), stress->value("picture_xxh3", "")}};
  return r;
}

}  // namespace etendue
