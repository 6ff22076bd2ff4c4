// The bandwidth that balances bias and variance, pixel by pixel ([Kaplanyan2013]).
//
// The mean of n passes at radii r_i has variance sum c / r_i^2 / n^2 and bias sum kappa laplacian(L) r_i^2 / n. With r_i ~
// i^(-1/6), the best rate, they come to 3/4 c / (n r_n^2) and 3/2 kappa laplacian(L) r_n^2, whose sum of variance and bias^2 is
// least at
//
//   r_n^6 = c / (6 (kappa laplacian(L))^2 n).
//
// Both unknowns are estimated from the pixel's photons so far, each reflecting the luminance l_j:
//
//   c             the mean of r^2 sum_j (l_j K_j)^2, K_j the kernel at photon j: photons are a Poisson process, so that this
//                 sum is the variance of sum_j l_j K_j
//   laplacian(L)  the mean of sum_j l_j laplacian(W_h)(d_j), W_h(d) = 4 / (pi h^2) (1 - x)^3 the triweight, x = d^2 / h^2,
//                 for which laplacian(W_h) = 48 / (pi h^4) (1 - x) (3 x - 1); less its own variance where it is squared
//
// h = r_1 n^(-1/10), the best rate for second derivatives, bounds r_n from above, and so does 0.15 r_1 n^(-1/6) from below. The
// bounds alone make it consistent; between them MSE ~ n^(-2/3), with the best factor. A gather uses the estimates of earlier
// passes, so that its radius does not depend on its own photons.
//
// Deviations: the paper estimates the Laplacian along the surface's derivatives by finite differences of a kernel of bounded
// support; here the kernel is differentiated. Neither sees features smaller than h; at edges, where part of the disc is off the
// surface, the estimate is large and the radius becomes small, as it should.
#pragma once

#include "integrators/progressive/radius_policy.h"

namespace etendue {

class AdaptiveBandwidth {
 public:
  // Sums over the photons of one pass.
  class Observed {
   public:
    void begin(const GatherDisc& disc, const GatherPoint& at, const Rgb& throughput);
    void add(const Rgb& reflected, const vec3& /*offset*/, float distance_squared) {
      const float l = luminance(reflected * throughput_), x = distance_squared * per_reach_squared_;
      const double curvature = l * (1 - x) * (3 * x - 1);
      laplacian += curvature;
      laplacian_variance += curvature * curvature;
      squares += distance_squared <= radius_squared_ ? double{l} * l : 0;
    }

    // Without the factors 48 / (pi h^4), its square, and 1 / (pi r)^2 for the box kernel. Squares, and powers of lengths, are
    // double: floats would not hold them in small scenes.
    double laplacian = 0, laplacian_variance = 0, squares = 0;
    float radius_squared_ = 0, per_reach_squared_ = 0;

   private:
    Rgb throughput_{1};
  };

  // `kernel`: of the gather.
  AdaptiveBandwidth(InitialRadii radii, Kernel kernel);
  GatherDisc disc(const GatherSite& site) const;
  void update(std::size_t pixel, std::uint32_t pass, const Observed& observed);

 private:
  struct Pixel {
    float first;                                          // r_1
    float passes = 0;                                     // in which the pixel gathered
    double c = 0, laplacian = 0, laplacian_variance = 0;  // sums over the passes
  };

  std::vector<Pixel> pixels_;
  float kappa_, roughness_;
};

}  // namespace etendue
