// Timing for the comparison of structures: how long rays take.
#pragma once

#include "experiments/log/ray_kind.h"
#include "framework/query.h"

#include <span>

namespace etendue {

// Millions of rays a second on this thread: ray by ray through the interface (one indirect call a ray), or through the calls
// that take many. Shadow rays ask occluded(), others closest(). 0 where there are no rays.
double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);
double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);

// How many of `rays`, at most all, a structure can trace within `seconds`, estimated from the first few.
std::size_t affordable_rays(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, double seconds);

}  // namespace etendue
