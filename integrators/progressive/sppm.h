// Progressive photon mapping ([Hachisuka2008]) and stochastic progressive photon mapping ([Hachisuka2009]).
//
// The radius follows shared statistics (SharedStatistics in integrators/progressive/radius_policy.h): of the photons found in a
// pass a share alpha is kept, and the radius shrinks so that the density is kept. `sppm` sees a new point per pixel in every
// iteration and shares the statistics between all points of a pixel. `ppm` sees `points` fixed ones per pixel, each with
// statistics of its own; iteration i serves point i mod points. (They are traced again rather than kept, which costs a camera
// path, not the method.)
//
// r_n^2 ~ n^(alpha-1), so MSE ~ n^-min(alpha, 2 (1 - alpha)) in smooth regions. sppm is consistent. ppm is consistent only for
// what its fixed points see: the error of sampling each pixel `points` times stays, and so does each random choice at a
// dielectric.
//
// By default sppm has more photons a pass in diffuse scenes than elsewhere (integrators/progressive/progressive.h).
//
// As published, both gather with a box kernel, take direct light from photons too (`kernel`, `direct`), and leave r_1 to the
// user (`radius`).
#pragma once

#include "integrators/progressive/progressive.h"

namespace etendue {

struct SharedStatisticsParams : ProgressiveParams {
  float alpha = 0.7f;
};

struct SppmParams : SharedStatisticsParams {
  SppmParams() {
    photons_per_pixel = 0;
    neighbours = 0;
  }
};

struct PpmParams : SharedStatisticsParams {
  int points = 4;
};

template <class Visitor>
void describe(Visitor& v, SharedStatisticsParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "", "share of each pass's photons that is kept; 1: the radius stays");
  describe_progressive(v, p);
}

template <class Visitor>
void describe(Visitor& v, PpmParams& p) {
  v.integer("points", p.points, 1, 65536, "points", "visible points per pixel");
  describe(v, static_cast<SharedStatisticsParams&>(p));
}

IntegratorEntry ppm_entry();
IntegratorEntry sppm_entry();

}  // namespace etendue
