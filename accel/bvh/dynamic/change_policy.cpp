#include "accel/bvh/dynamic/change_policy.h"

namespace etendue {

namespace {

ChangePolicyEntry plain_entry(const char* name, const char* summary, ChangePolicy::Kind kind) {
  const auto make = [name, kind](const ParamMap& map) {
    read_params<NoParams>(map, name);
    return ChangePolicy{kind, {}};
  };
  return {name, summary, {}, make};
}

ChangePolicyEntry hybrid_entry() {
  const auto make = [](const ParamMap& map) {
    return ChangePolicy{ChangePolicy::Kind::hybrid, read_params<HybridParams>(map, "hybrid")};
  };
  return {"hybrid", "refit, and rebuild the subtrees that got worse", list_params<HybridParams>(), make};
}

}  // namespace

std::span<const ChangePolicyEntry> change_policies() {
  static const std::vector<ChangePolicyEntry> entries{
      plain_entry("refit", "boxes follow, the tree stays", ChangePolicy::Kind::refit),
      plain_entry("rebuild", "a new tree after every change", ChangePolicy::Kind::rebuild),
      hybrid_entry(),
  };
  return entries;
}

const ChangePolicyEntry& find_change_policy(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const ChangePolicyEntry& entry : change_policies()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw Error(where, unknown_name("policy", name, names));
}

}  // namespace etendue
