// The ratio expected of one method's error to another's, as an experiment states it before it runs:
//
//   [[ratios]]
//   # of this name, with these parameters among those set; each method that it selects is a row
//   method   = "irradiance-cache metric=split-sphere records=1000"
//   over     = "irradiance-cache metric=tabellion records=1000"     # likewise, but one method alone
//   scene    = "builtin:edge"                # default: every scene (that has the region)
//   region   = "smooth"                      # default: the whole image
//   expected = 4.1                           # RMSE of the one over that of the other; default: none
//   source   = "[Schwarzhaupt2012] figure 1" # whose figure that is; wherever there is one
//
// Kept in the log with the laws of rates (rate_law.h); like these, they can be changed without running anything again.
#pragma once

#include "experiments/config/config_tree.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct RateContext;

struct RatioClaim {
  std::string method, over, scene, region;  // scene empty: every one; region empty: the whole image
  std::optional<double> expected;
  std::string source;

  bool operator==(const RatioClaim&) const = default;
};

// Throw Error.
std::vector<RatioClaim> read_ratios(const ConfigNode& node, const RateContext& context);

}  // namespace etendue
