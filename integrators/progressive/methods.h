// The progressive photon mappers: what they share is in integrators/progressive/progressive.h, and each has a policy for its
// radii (integrators/progressive/radius_policy.h).
//
//   ppm              [Hachisuka2008]: statistics of each of `points` fixed visible points per pixel (SharedStatistics)
//   sppm             [Hachisuka2009]: a new visible point in every iteration, statistics shared by pixel
//   ppm-memoryless   [Knaus2011]: a fixed sequence of radii (MemorylessRadius)
//   appm             [Kaplanyan2013]: radii that balance variance and curvature (AdaptiveBandwidth)
//   cppm             [Lin2020]: the radius shrinks only when a test finds photons uneven (ChiSquaredRadius)
//
// ppm and sppm. Of the photons found in a pass a share alpha is kept, and the radius shrinks so that the density is kept.
// Iteration i of ppm serves point i mod points. (The points are traced again rather than kept, which costs a camera path, not
// the method.) r_n^2 ~ n^(alpha-1), so MSE ~ n^-min(alpha, 2 (1 - alpha)) in smooth regions. sppm is consistent. ppm is
// consistent only for what its fixed points see: the error of sampling each pixel `points` times stays, and so does each random
// choice at a dielectric. By default sppm has more photons a pass in diffuse scenes than elsewhere. As published, both gather
// with a box kernel, take direct light from photons too (`kernel`, `direct`), and leave r_1 to the user (`radius`).
//
// ppm-memoryless. r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1), whatever photons are found: there is no state but r_1, so passes are
// independent of each other. MSE(n) = V1 Gamma(1 + alpha) / (2 - alpha) n^-alpha + (B1 / (alpha Gamma(1 + alpha)))^2 n^(-2 (1 -
// alpha)) with V1 the variance and B1 = kappa r_1^2 laplacian(E) the bias of the first pass; alpha = 2/3 balances the two
// ([Kaplanyan2013]). Within r of a discontinuity the bias is no smaller for a smaller r, only its share of the image is: there
// MSE ~ n^(-(1 - alpha) / 2).
//
// appm. Radii are wide where light is even, narrow at shadows, caustics and edges; MSE ~ n^(-2/3) in smooth regions.
//
// cppm. MSE ~ n^(-2/3) where light is uneven, n^-1 where not.
#pragma once

#include "framework/integrator.h"

namespace etendue {

IntegratorEntry ppm_entry();
IntegratorEntry sppm_entry();
IntegratorEntry ppm_memoryless_entry();
IntegratorEntry appm_entry();
IntegratorEntry cppm_entry();

}  // namespace etendue
