#include "experiments/kinds/claims/claims_config.h"

#include "experiments/config/config_keys.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/rows.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

ClaimMeasure read_measure(const ConfigNode& node) {
  TableReader row(node, "claims.measures");
  ClaimMeasure measure;
  measure.measurement = &find_measurement(row.needed_text("name"), row.need("name").where);
  for (const ConfigNode* scene : list_elements(row.need("scenes"), "scenes", "an array of scenes")) {
    measure.scenes.push_back(read_text(*scene, "scenes", "names or paths in quotes"));
    check_claim_scene(measure.scenes.back(), scene->where);
    if (std::ranges::count(measure.scenes, measure.scenes.back()) > 1)
      throw Error(scene->where, fmt::format("scene '{}' stands there twice", measure.scenes.back()));
  }
  if (const ConfigNode* expect = row.find("expect")) {
    const Measurement& measurement = *measure.measurement;
    measure.expect = read_expectations(*expect, measurement.name + ": expect", entry_names(measurement.quantities));
  }
  row.flag("large", measure.large);
  row.finish();
  return measure;
}

Claim read_claim(const ConfigNode& node) {
  TableReader row(node, "claims");
  Claim claim{{.id = static_cast<int>(row.needed_whole("id", 1, 9999)),
               .claim = row.needed_text("claim"),
               .source = row.needed_text("source"),
               .claimed = row.needed_text("claimed")}};
  row.text("reading", claim.reading);
  bool judged = false;
  for (const ConfigNode& measure : read_tables(row.need("measures"), "claims.measures")) {
    claim.measures.push_back(read_measure(measure));
    judged = judged || !claim.measures.back().expect.empty();
    const auto same = [&](const ClaimMeasure& other) { return other.measurement == claim.measures.back().measurement; };
    if (std::ranges::count_if(claim.measures, same) > 1)
      throw Error(measure.where, fmt::format("claims: '{}' stands there twice in claim {}",
                                             claim.measures.back().measurement->name, claim.id));
  }
  if (!judged)
    throw Error(node.where, fmt::format("claims: nothing judges claim {}; expected expect = {{ … }} in a measure", claim.id));
  row.finish();
  return claim;
}

}  // namespace

ClaimsChoice read_claims(const ConfigNode& claims, const ConfigNode* timing) {
  ClaimsChoice choice;
  if (timing) {
    TableReader reader(*timing, "timing");
    reader.whole("resolution", choice.resolution, 8, 4096);
    reader.whole("repetitions", choice.repetitions, 1, 1000);
    reader.flag("large", choice.large);
    reader.finish();
  }
  choice.rows = read_rows<Claim>(claims, "claims", read_claim);
  return choice;
}

}  // namespace etendue
