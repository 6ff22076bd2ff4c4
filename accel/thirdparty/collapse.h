// Coarser meshes by edge collapse, as CGAL does it ([Cacciola2022]): always the edge whose removal costs least goes next, to
// the place that keeps volume, boundary and area best ([Lindstrom1998]). It is present where CGAL was found, and under the
// GPL-3 like CGAL's tree (cgal.h).
//
// Vertices at the same place are joined first. Triangles that would make the mesh non-manifold stay as they are. The same mesh
// gives the same triangles each time.
#pragma once

#include "framework/core/vec.h"

#include <span>
#include <vector>

namespace etendue {

struct CoarseMesh {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
  float distance = 0;  // metres, from the coarse mesh to that of 10,000 vertices of the fine one that lies farthest off
};

// One mesh for each of the `shares`, which fall from at most 1: about so much of the valid triangles is left. Throws Error
// where this build was made without CGAL.
std::vector<CoarseMesh> collapse_edges(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                       std::span<const double> shares);

}  // namespace etendue
