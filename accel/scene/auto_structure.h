// The ray structure that takes the least time for a scene and a number of rays, its build included.
//
// Three builders span what building can trade for tracing, all in the layout that suits scene and machine: `lbvh` sorts,
// `binned-sah` weighs areas, `sah reinsertion=9` optimises what it built. Each is told by the nanoseconds that it takes to
// build a primitive and to trace a ray on one thread, as results/meshes has them for meshes of 66,000 to 100,000 triangles; in
// scenes of less than 4096 primitives builds take no time that counts, and nothing else was measured to be faster than
// `binned-sah`. Which is chosen depends on the two numbers alone.
#pragma once

#include "accel/registry.h"

namespace etendue {

// `rays`: how many will be traced.
MethodChoice choose_structure(const Scene& scene, double rays);

RayEntry auto_structure_entry();

}  // namespace etendue
