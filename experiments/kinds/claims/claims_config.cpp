#include "experiments/kinds/claims/claims_config.h"

#include "experiments/config/config_keys.h"
#include "experiments/kinds/claims/claim_scenes.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

ClaimMeasure read_measure(const ConfigNode& node) {
  TableReader reader(node, "claims.measures");
  ClaimMeasure measure;
  const ConfigNode& name = required(reader, node, "claims.measures", "name");
  measure.measurement = &find_measurement(read_text(name, "claims.measures.name"), name.where);
  const ConfigNode& scenes = required(reader, node, "claims.measures", "scenes");
  for (const ConfigNode* scene : list_elements(scenes, "scenes", "an array of scenes")) {
    measure.scenes.push_back(read_text(*scene, "scenes", "names or paths in quotes"));
    check_claim_scene(measure.scenes.back(), scene->where);
    if (std::count(measure.scenes.begin(), measure.scenes.end(), measure.scenes.back()) > 1)
      throw Error(scene->where, fmt::format("scene '{}' stands there twice", measure.scenes.back()));
  }
  if (const ConfigNode* expect = reader.find("expect")) {
    std::vector<std::string> names;
    for (const Quantity& quantity : measure.measurement->quantities) names.push_back(quantity.name);
    measure.expect = read_expectations(*expect, measure.measurement->name + ": expect", names);
  }
  if (const ConfigNode* large = reader.find("large")) measure.large = read_flag(*large, "large");
  reader.finish();
  return measure;
}

Claim read_claim(const ConfigNode& node) {
  TableReader reader(node, "claims");
  Claim claim;
  claim.id = static_cast<int>(read_whole(required(reader, node, "claims", "id"), "claims.id", 1, 9999));
  claim.claim = read_text(required(reader, node, "claims", "claim"), "claims.claim");
  claim.source = read_text(required(reader, node, "claims", "source"), "claims.source");
  claim.claimed = read_text(required(reader, node, "claims", "claimed"), "claims.claimed");
  if (const ConfigNode* reading = reader.find("reading")) claim.reading = read_text(*reading, "claims.reading");
  const ConfigNode& measures = required(reader, node, "claims", "measures");
  if (!measures.array() || measures.array()->empty()) wrong_type(measures, "claims.measures", "[[claims.measures]] tables");
  bool judged = false;
  for (const ConfigNode& measure : *measures.array()) {
    claim.measures.push_back(read_measure(measure));
    judged = judged || !claim.measures.back().expect.empty();
    const auto same = [&](const ClaimMeasure& other) { return other.measurement == claim.measures.back().measurement; };
    if (std::count_if(claim.measures.begin(), claim.measures.end(), same) > 1)
      throw Error(measure.where, fmt::format("claims: '{}' stands there twice in claim {}",
                                             claim.measures.back().measurement->name, claim.id));
  }
  if (!judged)
    throw Error(node.where, fmt::format("claims: nothing judges claim {}; expected expect = {{ … }} in a measure", claim.id));
  reader.finish();
  return claim;
}

}  // namespace

ClaimsChoice read_claims(const ConfigNode& claims, const ConfigNode* timing) {
  ClaimsChoice choice;
  if (timing) {
    TableReader reader(*timing, "timing");
    if (const auto* n = reader.find("resolution"))
      choice.resolution = static_cast<int>(read_whole(*n, "timing.resolution", 8, 4096));
    if (const auto* n = reader.find("repetitions"))
      choice.repetitions = static_cast<int>(read_whole(*n, "timing.repetitions", 1, 1000));
    if (const auto* n = reader.find("large")) choice.large = read_flag(*n, "timing.large");
    reader.finish();
  }
  if (!claims.array() || claims.array()->empty()) wrong_type(claims, "claims", "[[claims]] tables");
  for (const ConfigNode& node : *claims.array()) {
    choice.rows.push_back(read_claim(node));
    for (std::size_t i = 0; i + 1 < choice.rows.size(); ++i)
      if (choice.rows[i].id == choice.rows.back().id)
        throw Error(node.where, fmt::format("claims: id {} stands there twice", choice.rows.back().id));
  }
  return choice;
}

}  // namespace etendue
