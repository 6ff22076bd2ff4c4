// Warnings of what in a scene is too small for the coordinates of floats.
#pragma once

#include "framework/scene/scene.h"

#include <string>
#include <vector>

namespace etendue {

// There is a warning for instances that are small against their distance from the origin, and one for primitives that are, with
// the extent, the distance in the file, and the distance there between one float and the next (ulp). There is one for
// primitives that are thin against the clearance of rays that leave large ones, one for what is small against it, and one for
// scenes too small for the range of floats. Most scenes get none.
//
// Rays start off surfaces by three to six ulps of their coordinates (framework/scene/clearance.h). That changes images by less
// than 1e-3 where what is seen spans `fewest_ulps` or more.
std::vector<std::string> precision_warnings(const Scene& scene);

}  // namespace etendue
