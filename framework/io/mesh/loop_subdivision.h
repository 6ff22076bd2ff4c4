// Subdivision surfaces of triangle meshes ([Loop1987]), with the weights that pbrt uses.
#pragma once

#include "framework/io/mesh/mesh.h"

namespace etendue {

// `levels` splits of each triangle into four, then every vertex goes to the limit surface and gets its normal there. Normals
// point against the winding of the faces, as pbrt's do. Edges of a single face are boundaries. Throws Error without a place on
// an edge of more than two faces, and where the result would have more than 2^26 triangles.
TriangleMesh subdivide(const TriangleMesh& control, int levels);

}  // namespace etendue
