#include "experiments/config/ratio_claim.h"

#include "experiments/config/rate_law.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

std::string read_selection(TableReader& reader, const ConfigNode& table, const char* key, const RateContext& context,
                           std::size_t most) {
  const auto* node = reader.find(key);
  if (!node) throw Error(table.where, fmt::format("ratios: a ratio without {0}; expected {0} = \"…\"", key));
  const std::string wanted = read_text(*node, std::string("ratios.") + key);
  std::vector<std::string> labels;
  for (const Method& method : context.integrators) labels.push_back(method.label());
  const auto selected = static_cast<std::size_t>(
      std::count_if(labels.begin(), labels.end(), [&](const std::string& label) { return selects(wanted, label); }));
  if (selected == 0) throw Error(node->where, "ratios: " + unknown_name("method", wanted, labels));
  if (selected > most)
    throw Error(node->where, fmt::format("ratios: '{}' selects {} of the integrators; expected {}", wanted, selected, most));
  return wanted;
}

RatioClaim read_claim(const ConfigNode& node, const RateContext& context) {
  if (!node.table()) wrong_type(node, "ratios", "tables { method, over, … }");
  TableReader reader(node, "ratios");
  RatioClaim claim;
  read_place(reader, "ratios", context, claim.scene, claim.region);
  claim.method = read_selection(reader, node, "method", context, context.integrators.size());
  claim.over = read_selection(reader, node, "over", context, 1);
  const auto *expected = reader.find("expected"), *source = reader.find("source");
  reader.finish();
  if (expected) claim.expected = read_number(*expected, "ratios.expected", 1e-6, 1e6);
  if (source) claim.source = read_text(*source, "ratios.source");
  if (expected && !source)
    throw Error(expected->where, "ratios: expected without a source; expected source = \"whose figure this is\"");
  if (std::find(context.metrics.begin(), context.metrics.end(), "mse") == context.metrics.end())
    throw Error(node.where, "ratios: mse is not among the metrics; expected metrics = [\"mse\", …]");
  return claim;
}

}  // namespace

std::vector<RatioClaim> read_ratios(const ConfigNode& node, const RateContext& context) {
  std::vector<RatioClaim> claims;
  for (const ConfigNode* element : list_elements(node, "ratios", "[[ratios]] tables { method, over, … }"))
    claims.push_back(read_claim(*element, context));
  return claims;
}

}  // namespace etendue
