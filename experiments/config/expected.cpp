#include "experiments/config/expected.h"

#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

Expected read_fraction(const ConfigNode& node, const std::string& key) {
  const std::string& text = *node.text();
  const std::size_t slash = text.find('/');
  const auto above = parse_number(std::string_view(text).substr(0, slash));
  const auto below = slash == std::string::npos ? 1.0 : parse_number(std::string_view(text).substr(slash + 1));
  if (!above || !below || *below == 0)
    throw Error(node.where, fmt::format("{}: '{}'; expected a number, a fraction such as \"-2/3\" or an interval", key, text));
  const double value = *above / *below;
  return {value, value, text};
}

Expected read_expected(const ConfigNode& node, const std::string& key) {
  if (node.text()) return read_fraction(node, key);
  const auto* ends = node.array();
  if (!ends) {
    const double value = read_number(node, key, -1e30, 1e30);
    return {value, value, fmt::format("{:g}", value)};
  }
  if (ends->size() != 2) wrong_type(node, key, "an interval [low, high], such as [1.2, 1.3] or [1, inf]");
  const Expected expected{read_number((*ends)[0], key, -endless, endless), read_number((*ends)[1], key, -endless, endless)};
  if (expected.low > expected.high)
    throw Error(node.where, fmt::format("{}: [{:g}, {:g}] is empty; expected low <= high", key, expected.low, expected.high));
  return expected;
}

}  // namespace

std::map<std::string, Expected> read_expectations(const ConfigNode& node, const std::string& owner,
                                                  const std::vector<std::string>& quantities) {
  TableReader reader(node, owner, fmt::format("a table {{ {} = value or [low, high] }}", quantities.front()));
  std::map<std::string, Expected> expectations;
  for (const std::string& quantity : quantities)
    if (const ConfigNode* expected = reader.find(quantity))
      expectations[quantity] = read_expected(*expected, owner + "." + quantity);
  reader.finish();
  if (expectations.empty())
    throw Error(node.where, fmt::format("{}: empty; expected one of {}", owner, fmt::join(quantities, ", ")));
  return expectations;
}

}  // namespace etendue
