// How a tree is updated when its boxes move (dynamic_tree.h), by name.
#pragma once

#include "framework/core/params.h"

#include <functional>
#include <span>

namespace etendue {

// The defaults were chosen by the motions of experiments/dynamic.toml.
struct HybridParams {
  float changed_fraction = 0.1f;
  float sah_growth = 1.3f;
  float least_gain = 0.2f;
};

template <class Visitor>
void describe(Visitor& v, HybridParams& params) {
  v.number("changed_fraction", params.changed_fraction, 0, 1, "of the items",
           "changed since subtrees were last judged; below it, refit alone");
  v.number("sah_growth", params.sah_growth, 1, 1000, "times", "a subtree whose cost has grown by more has worsened");
  v.number("least_gain", params.least_gain, 0, 1, "of the cost",
           "of the whole tree that rebuilding the worsened subtrees must promise to spare");
}

struct ChangePolicy {
  enum class Kind : std::uint8_t { refit, rebuild, hybrid };
  Kind kind = Kind::hybrid;
  HybridParams hybrid;
};

struct ChangePolicyEntry {
  std::string name, summary;
  std::vector<ParamInfo> params;
  std::function<ChangePolicy(const ParamMap&)> make;
};

std::span<const ChangePolicyEntry> change_policies();
const ChangePolicyEntry& find_change_policy(const std::string& name, const Location& where);  // throws Error

}  // namespace etendue
