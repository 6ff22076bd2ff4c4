// Direct light that light samples hardly ever find: a lamp of little power where another, which may be hidden, has nearly all.
// The image lacks it, and is calm.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

// Says that direct light on what is seen comes from lights that the method's light samples choose too seldom to find it, and
// what brings it; "" where none does. To be asked once the method has said how it chooses among lights.
std::string lights_seldom_chosen(const RenderContext& context, const std::string& method);

}  // namespace etendue
