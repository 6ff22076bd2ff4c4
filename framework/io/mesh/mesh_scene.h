// A bare mesh as a scene to look at.
#pragma once

#include "framework/io/mesh/mesh.h"
#include "framework/scene/scene.h"

namespace etendue {

// The mesh in grey (diffuse, 0.6), seen from a little above and to the side (y is up, right-handed), 512 x 512, under a
// constant sky and a directional key light. Throws Error when the mesh's extent has no square in single precision.
Scene mesh_scene(TriangleMesh mesh, const std::string& name);

}  // namespace etendue
