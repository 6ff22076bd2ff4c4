#include "experiments/config/config_quick.h"

#include "experiments/config/config_keys.h"

#include <span>
#include <string_view>

namespace etendue {

namespace {

// What `--quick` means where an experiment has no [quick] table of its own.
constexpr const char* default_dynamic_quick[] = {"seeds=1", "dynamic.frames=10", "dynamic.resolution=32",
                                                 "dynamic.repetitions=1"};
constexpr const char* default_points_quick[] = {"points.counts=[10, 1000, 10000]", "points.queries=200",
                                                "points.repetitions=3"};
constexpr const char* default_balls_quick[] = {"balls.counts=[10, 100, 1000]", "balls.queries=200", "balls.repetitions=3"};
constexpr std::string_view default_claims_quick = "timing = { resolution = 32, repetitions = 3, large = false }\n";
constexpr std::string_view default_stress_quick = "seeds = 1\nresolution = [32, 32]\n";
constexpr std::string_view default_quick = "seeds = 1\nbudget = { time = \"0.3s\" }\nresolution = [64, 64]\n";

}  // namespace

void apply_quick(ConfigNode& root) {
  auto& table = std::get<ConfigNode::Table>(root.value);
  const auto own = table.find("quick");
  const auto shortened = [&](const char* key, std::span<const char* const> assignments) {
    const auto found = table.find(key);
    if (own != table.end() || found == table.end() || !found->second.table()) return false;
    for (const char* assignment : assignments) apply_override(root, assignment);
    return true;
  };
  if (shortened("dynamic", default_dynamic_quick) || shortened("points", default_points_quick) ||
      shortened("balls", default_balls_quick))
    return;
  const std::string_view usual = table.contains("claims")   ? default_claims_quick
                                 : table.contains("stress") ? default_stress_quick
                                                            : default_quick;
  ConfigNode quick = own == table.end() ? parse_config(usual, "--quick") : own->second;
  if (const auto timing = table.find("structures");
      own == table.end() && timing != table.end() && read_structures(timing->second))
    apply_override(quick, "structures={ resolution = 64, repetitions = 1 }");
  if (!quick.table()) wrong_type(quick, "quick", "a table of keys to replace");
  for (const auto& [key, value] : *quick.table()) {
    if (key == "quick") throw Error(value.key_where, "quick: a [quick] inside [quick]; expected keys of the experiment");
    table.insert_or_assign(key, value);
  }
}

}  // namespace etendue
