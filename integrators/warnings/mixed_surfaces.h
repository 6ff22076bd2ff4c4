// Surfaces so near to each other that light on one may be taken for light on the other.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

// Says that a surface that stops but a part of the light lies so near to another of its own layer that the method, which shares
// light between near points, may take that on one for that on the other; "" where it does not, or none is seen.
std::string surfaces_mixed(const RenderContext& context, const std::string& method, const ParamMap& params = {});

}  // namespace etendue
