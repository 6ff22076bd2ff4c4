// Mixtures of two materials that are again one of the materials there are.
#pragma once

#include "framework/materials/material.h"

#include <optional>

namespace etendue {

// The material that scatters as (1 - share) `a` and `share` `b` together, where both are of one kind, alike but for their
// constant colours; else none. `share` lies in 0 .. 1 and may differ by channel.
std::optional<Material> mixed(const Material& a, const Material& b, const Rgb& share);

}  // namespace etendue
