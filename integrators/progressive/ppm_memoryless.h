// Progressive photon mapping without statistics ([Knaus2011]).
//
// r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1), whatever photons are found: there is no state but r_1, so passes are independent of
// each other. MSE(n) = V1 Gamma(1 + alpha) / (2 - alpha) n^-alpha + (B1 / (alpha Gamma(1 + alpha)))^2 n^(-2 (1 - alpha)) with
// V1 the variance and B1 = kappa r_1^2 laplacian(E) the bias of the first pass; alpha = 2/3 balances the two ([Kaplanyan2013]).
// Within r of a discontinuity the bias is no smaller for a smaller r, only its share of the image is: there MSE ~ n^(-(1 -
// alpha) / 2).
#pragma once

#include "integrators/progressive/progressive.h"

namespace etendue {

struct MemorylessParams : ProgressiveParams {
  float alpha = 2.0f / 3.0f;
};

template <class Visitor>
void describe(Visitor& v, MemorylessParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "", "the larger, the slower the radius shrinks; 1: it stays");
  describe_progressive(v, p);
}

IntegratorEntry ppm_memoryless_entry();

}  // namespace etendue
