// The radius shrinks when Pearson's chi-squared test finds the photons within it uneven ([Lin2020]).
//
// Where photons are evenly distributed, no kernel has bias at any radius. So the radius stays, and pass after pass the photons
// are counted in 12 parts of equal area (two rings of six sectors). Once there are n_min of them the counts are tested for
// evenness at 95 %. If the test rejects evenness, the radius shrinks: to the inner ring where that passes on its own (r^2 / 2),
// else by r^2 -> 0.8 r^2. The counts then restart and n_min grows by the factor beta, so that later tests have enough photons
// to detect smaller differences. n_min is 12 at first: for parts of equal probability the statistic is near its limit from n >=
// 10 and n^2 / parts >= 10 on ([Koehler1980]).
//
// With the paper's beta = 1.5625, r^2 ~ n^(-1/3) where every test rejects, the best rate in smooth regions; but at edges, where
// tests reject until the disc no longer reaches the edge, the radius shrinks slowly. With the default of 1.1 it follows the
// tests closely.
//
// hypothesis "even" is the paper's first: the density is constant. "odd" is its other one: counts of opposite sectors are added
// first, because a kernel has no bias from a linear slope. Slopes then pass, but so does an edge through the exact centre.
//
// Consistent, since persistent unevenness is rejected sooner or later: a curvature that exceeds a noise of n^-1/2 r^-1 leads to
// r^2 ~ n^(-1/3), hence MSE ~ n^(-2/3); MSE ~ n^-1 where the light is even.
#pragma once

#include "integrators/progressive/radius_policy.h"

#include <array>

namespace etendue {

class ChiSquaredRadius {
 public:
  static constexpr int rings = 2, sectors = 6, parts = rings * sectors, first_count = parts;

  // Counts in the parts; those of the inner ring first.
  class Observed {
   public:
    void begin(const GatherDisc& disc, const GatherPoint& at, const Rgb& throughput);
    void add(const Rgb& reflected, const vec3& offset, float distance_squared);

    std::array<std::uint32_t, parts> counts{};

   private:
    vec3 tangent_{0}, bitangent_{0};
    float half_squared_ = 0;  // the inner ring's edge, squared
  };

  struct Rules {
    float beta = 1.1f;
    bool odd = false;
  };

  ChiSquaredRadius(InitialRadii radii, const Rules& rules);
  GatherDisc disc(const GatherSite& site) const { return GatherDisc(pixels_[site.pixel].radius); }
  void update(std::size_t pixel, std::uint32_t pass, const Observed& observed);

  // Is the unevenness of the first `rings_tested` rings within what even light would show in 95 % of cases?
  static bool looks_even(const std::array<std::uint32_t, parts>& counts, int rings_tested, bool odd);

 private:
  struct Pixel {
    float radius;
    float enough;  // n_min
    std::array<std::uint32_t, parts> counts{};
  };

  std::vector<Pixel> pixels_;
  Rules rules_;
};

}  // namespace etendue
