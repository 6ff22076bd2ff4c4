// Infinite planes beside any ray structure: they have no box, so they stand outside the tree and are tested first, which
// already shortens the ray. They are asked only in scenes that have planes.
#pragma once

#include "framework/query.h"
#include "framework/scene/scene.h"

#include <memory>

namespace etendue {

// The structure itself where the scene has no planes.
std::unique_ptr<RayQuery> with_planes(std::unique_ptr<RayQuery> structure, const Scene& scene);

}  // namespace etendue
