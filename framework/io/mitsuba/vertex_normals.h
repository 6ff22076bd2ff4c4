// Smooth normals for meshes that come without, as Mitsuba makes them.
#pragma once

#include "framework/io/mesh/mesh.h"

namespace etendue {

// The normals of the faces around each vertex, weighted by the faces' angles there [Thurmer1998]; zero where there are none.
std::vector<vec3> smooth_normals(const TriangleMesh& mesh);

}  // namespace etendue
