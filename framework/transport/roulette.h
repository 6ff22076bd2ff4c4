// Russian roulette ([Arvo1990]): a path goes on with a probability by which its throughput is divided, so that the mean stays.
#pragma once

#include "framework/core/sampler.h"
#include "framework/core/vec.h"

#include <algorithm>

namespace etendue {

// The usual probability: the largest component of the throughput, at most 0.95. `eta_scale` undoes the eta^2 of refractions,
// which is no absorption.
inline float survival_of(const Rgb& throughput, float eta_scale) {
  return std::min(0.95f, max_component(throughput) * eta_scale);
}

// Draws one number; false where the path ends.
template <class Numbers>
bool survives_roulette(Rgb& throughput, float survival, Numbers& numbers) {
  if (!(numbers.get_1d() < survival)) return false;
  throughput /= survival;
  return true;
}

}  // namespace etendue
