// Light that a method cannot bring, or brings by chance alone.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

// Says that light on what is seen comes by way of specular surfaces, that the method finds it by chance alone, if at all, and
// which method brings it; of methods with photons or light paths, that hardly any of these land on what is seen, where their
// `params` do not guide them. "" where neither holds. Runs a pilot where the scene needs one to tell.
std::string light_out_of_reach(const RenderContext& context, const std::string& method, const ParamMap& params = {});

}  // namespace etendue
