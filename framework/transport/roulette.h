// Russian roulette ([Arvo1990]): a path goes on with a probability by which its throughput is divided, so that the mean stays.
#pragma once

#include "framework/core/sampler.h"
#include "framework/core/vec.h"

#include <algorithm>

namespace etendue {

// The usual probability: the largest component of the throughput, at most 0.95. `eta_scale` undoes the eta^2 of refractions,
// which is no absorption. Where paths scatter little, as `evenness` above 1 says, it is so many times as much, and may be 1.
template <class V>
auto survival_of(const V& throughput, LaneOf<V> eta_scale, float evenness = 1) {
  const LaneOf<V> most = evenness > 1 ? 1.0f : 0.95f;
  return min(most, max_component(throughput) * eta_scale * LaneOf<V>(evenness));
}

// Draws one number; false where the path ends.
template <class V, class Numbers>
Mask<LaneOf<V>> survives_roulette(V& throughput, LaneOf<V> survival, Numbers& numbers) {
  throughput /= survival;
  return numbers.get_1d() < survival;
}

}  // namespace etendue
