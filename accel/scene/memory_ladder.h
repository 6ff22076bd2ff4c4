// Which structures stand in for one that exceeds its memory budget (memory_budget.h).
#pragma once

#include "accel/registry.h"

namespace etendue {

// Builds `entry` within the parameter `memory`, or a replacement: first itself in the leanest layout, then trees in that layout
// by builders that take less memory, and at last brute force that reads the primitives in place and keeps next to nothing.
std::unique_ptr<RayQuery> make_within_memory(const RayEntry& entry, const Scene& scene, const ParamMap& map);

}  // namespace etendue
