// SMF meshes, the format of Garland's simplification tools: `v x y z`, `f a b c`, `begin` and `end`.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <string>
#include <string_view>

namespace etendue {

// Indices count from 1 within the innermost begin/end block, or back from -1. Attributes (bind, n, c, r, tex) are left out;
// transforms (trans, scale, rot, mmult, mload, set) are errors, as they would move the mesh. Throws Error at `file:line:col`.
TriangleMesh read_smf(const std::string& path);
TriangleMesh parse_smf(std::string_view text, const std::string& name);

}  // namespace etendue
