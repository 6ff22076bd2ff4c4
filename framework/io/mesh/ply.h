// PLY meshes: ascii, binary little-endian and binary big-endian 1.0.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <string>
#include <string_view>

namespace etendue {

// Vertices x y z, with nx ny nz and u v (or s t, texture_u texture_v, texture_s texture_t) where the file has them; faces from
// the list vertex_indices (or vertex_index), polygons as fans. Other properties and elements are skipped. Throws Error at
// `file:line:col` in headers and ascii bodies, at `file: byte N` in binary ones. A file without faces is an error.
TriangleMesh read_ply(const std::string& path);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name);

}  // namespace etendue
