// Adaptive progressive photon mapping ([Kaplanyan2013]).
//
// Each pixel's radius balances the variance and the curvature estimated so far: wide where light is even, narrow at shadows,
// caustics and edges. See integrators/progressive/adaptive_bandwidth.h for the rule, its rate (MSE ~ n^(-2/3) in smooth
// regions) and its bounds, and integrators/progressive/progressive.h for the rest.
#pragma once

#include "integrators/progressive/progressive.h"

namespace etendue {

struct AppmParams : ProgressiveParams {};

template <class Visitor>
void describe(Visitor& v, AppmParams& p) {
  describe_progressive(v, p);
}

IntegratorEntry appm_entry();

}  // namespace etendue
