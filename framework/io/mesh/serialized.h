// Mitsuba's serialized meshes, versions 3 and 4: several in a file, each compressed by zlib.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <string>
#include <string_view>

namespace etendue {

// The mesh at `index`, from 0. Throws Error: `name: byte N`, what is wrong, what was expected.
TriangleMesh parse_serialized(std::string_view bytes, const std::string& name, int index);

}  // namespace etendue
