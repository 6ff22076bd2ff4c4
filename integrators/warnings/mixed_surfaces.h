// Surfaces so near to each other that light on one may be taken for light on the other.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

// Says that a partly transparent surface lies so near to another of its layer that the method, which shares light between near
// points, may confuse the light on the two; "" where it does not, or none is seen.
std::string surfaces_mixed(const RenderContext& context, const std::string& method, const ParamMap& params = {});

}  // namespace etendue
