// `--quick`: an experiment made short enough to see that it works, by its own [quick] table, or else by a default for its kind
// (one seed, little time, a small image).
#pragma once

#include "experiments/config/config_tree.h"

namespace etendue {

// Replaces keys of the experiment `root` by those of its [quick] table. A key is replaced as a whole, so that
// budget = { samples = 4 } leaves nothing of budget = { time = "60s" }. Throws Error where [quick] is not a table.
void apply_quick(ConfigNode& root);

}  // namespace etendue
