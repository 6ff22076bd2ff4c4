// Surfaces that lie exactly where others do. Of triangles that are the same to the last bit, or lie in one plane at a height of
// 0, rays meet always the same one, so that no ray tells: the scene's primitives are searched for those that hold a point.
#pragma once

#include "framework/integrator.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

// For each list of points, whether one of them lies, as far as rounding tells, on a surface of another material too, where one
// of the two is glass. Looks once at every primitive of the instances near which there are points, and at the
// first of these where they are very many.
std::vector<bool> coincide_with_others(const Scene& scene, std::span<const std::vector<SurfacePoint>> points);

// Says that lights lie in one place with other surfaces, or with each other, which rays meet in their place: light samples and
// photons know nothing of that. "" where less than 1 % of their power does. Of more than 1,024 lights so many are asked.
std::string lights_coincide(const RenderContext& context);

}  // namespace etendue
