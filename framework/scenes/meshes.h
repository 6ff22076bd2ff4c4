// A mesh as large as asked for, of built-in scenes for structures rather than for methods.
#pragma once

#include "framework/scene/builder.h"

namespace etendue {

// A ball displaced by five octaves of noise, on a grid of longitudes and latitudes; a quarter more of the former.
MeshData rough_ball(const vec3& centre, float radius, int triangles);

}  // namespace etendue
