// Places a reader's quadric: as another quadric, or as an instance of its own under the transform.
#pragma once

#include "framework/scene/geometry.h"
#include "framework/scene/transform.h"

#include <optional>

namespace etendue {

// The quadric that the transform makes of this one; none where only the transform itself can hold it: where it distorts, or
// where `keep_uvs` and it turns the axes that texture coordinates count from. Throws Error on what lies too far, or is too
// small.
std::optional<Quadric> placed_quadric(const Quadric& quadric, const Transform& transform, bool keep_uvs);

}  // namespace etendue
