// The radius of kernels that is given and not found: no larger than the scene.
//
// A kernel divides by the area of its disc. Where that is larger than all there is, nearly none of it is surface, and the image
// is black or nearly so, without a word. It is mostly a length in another unit that asks for this.
#pragma once

#include "framework/core/error.h"
#include "framework/scene/scene.h"

#include <fmt/format.h>

namespace etendue {

// Throws Error for a radius (metres) beyond the scene's diagonal. Infinite planes have none.
inline void check_given_radius(const Scene& scene, float radius) {
  if (!scene.planes.empty() || scene.bounds().empty()) return;
  const float diagonal = glm::length(scene.bounds().diagonal());
  if (radius > diagonal)
    throw Error(fmt::format("radius = {:.4g}: the scene measures {:.4g} m across; expected at most that", radius, diagonal));
}

}  // namespace etendue
