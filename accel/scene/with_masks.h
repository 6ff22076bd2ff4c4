// Surfaces that let rays through: a structure's answer is passed where its mask does not stop the ray, and the ray is traced on
// from there. It is built only over scenes that have masks, so that no kernel knows of them and opaque scenes pay nothing.
//
// Each candidate is decided on its own: by the mask where that is 0 or 1, and in between by a hash of the ray, the primitive
// and the distance, as pbrt-v4 does it. The share of rays that are stopped is then the opacity, whatever method asks, the same
// ray always meets the same, and two surfaces one behind the other decide independently.
//
// A ray goes on beyond the distance of what it has passed. Of surfaces that it meets at the same distance to the last bit, only
// the first is asked: what coincides with a transparent surface and has a higher number is passed with it.
#pragma once

#include "framework/query.h"
#include "framework/scene/scene.h"

#include <memory>

namespace etendue {

// The structure itself where the scene has no masks. The scene must outlive what is returned.
std::unique_ptr<RayQuery> with_masks(std::unique_ptr<RayQuery> structure, const Scene& scene);

}  // namespace etendue
