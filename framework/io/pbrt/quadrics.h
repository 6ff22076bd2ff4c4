// pbrt's quadrics in their own space: whole spheres, cylinders and disks as such, all others as surfaces over (u, v).
#pragma once

#include "framework/io/mesh/tessellate.h"
#include "framework/io/pbrt/params.h"
#include "framework/scene/geometry.h"

namespace etendue {

struct PbrtQuadric {
  std::optional<Quadric> whole;
  SurfacePatch patch;
};

// Nothing for a type that is no quadric: sphere, cylinder, disk, cone, paraboloid and hyperboloid are.
std::optional<PbrtQuadric> read_quadric(const std::string& type, const PbrtParams& params);

}  // namespace etendue
