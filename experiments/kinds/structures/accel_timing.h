// Timing for the comparison of structures: how long rays take, and statistics of a few repetitions.
#pragma once

#include "experiments/log/log.h"
#include "framework/query.h"

#include <functional>
#include <span>
#include <vector>

namespace etendue {

double seconds_of(const std::function<void()>& work);

// The median of repetitions with their quartiles; of none, zeros.
Measured summarise(std::span<const double> values);

// a[i] / b[i] for each repetition that both have; changes in the machine's speed, which affect repetitions close in time alike,
// cancel.
std::vector<double> ratios(std::span<const double> a, std::span<const double> b);

// Millions of rays a second on this thread: ray by ray through the interface (one indirect call a ray), or through the calls
// that take many. Shadow rays ask occluded(), others closest(). 0 where there are no rays.
double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);
double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);

// occluded() of many rays, where the interface has such a call; false where it has none.
template <class Query>
bool ask_occluded(const Query& structure, std::span<const Ray> rays, std::span<bool> occluded) {
  if constexpr (requires { structure.occluded(rays, occluded); }) {
    structure.occluded(rays, occluded);
    return true;
  }
  return false;
}

// How many of `rays`, at most all, a structure can trace within `seconds`, estimated from the first few.
std::size_t affordable_rays(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, double seconds);

}  // namespace etendue
