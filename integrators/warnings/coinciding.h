// Surfaces that lie exactly where others do. Where triangles are the same to the last bit, or lie in one plane at a height of
// 0, rays always meet the same one, so that no ray tells. So the scene's primitives are searched for those that hold a point.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

// Says that surfaces of different materials lie in one place, so that rays meet one or the other by chance, or always the same
// one, whatever the method; "" where none is seen. Where both are at the same distance to the last bit, it tells of glass
// alone.
std::string surfaces_coincide(const RenderContext& context);

// Says that lights lie in one place with other surfaces, or with each other, which rays meet in their place: light samples and
// photons know nothing of that. "" where less than 1 % of their power does. Where there are more than 1,024 lights, so many are
// asked.
std::string lights_coincide(const RenderContext& context);

}  // namespace etendue
