// Holes in a mesh, where a texture says that it is not opaque.
//
// It serves surfaces of which rays cannot ask the opacity (accel/scene/with_masks.h), such as lights: what has an opacity below
// a half is cut away. Triangles are split along that line, seven times at most and less often where there are many of them.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <functional>

namespace etendue {

// Gives the opacity at a vertex's texture coordinates and position, from 0 to 1.
using Opacity = std::function<float(const vec2& uv, const vec3& position)>;

void cut_away(TriangleMesh& mesh, const Opacity& opacity);

}  // namespace etendue
