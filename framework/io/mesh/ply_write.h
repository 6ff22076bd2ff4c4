// Triangle meshes as PLY files.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <string>

namespace etendue {

// The bytes of a binary little-endian PLY that parse_ply reads to the same bits: x y z, nx ny nz and u v where the mesh has
// them, then triangles.
std::string encode_ply(const TriangleMesh& mesh);

}  // namespace etendue
