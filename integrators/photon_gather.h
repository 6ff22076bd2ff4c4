// A map of photons and the radiance estimated from it ([Jensen1996], [Jensen2001]).
//
// Photons arrive in proportion to irradiance, cosine included, so the estimate is sum f_r power K(d) without a further N.L.
//
// With k > 0 the k-th nearest photon sets the kernel's radius and is itself not counted: for any normalised kernel this is
// unbiased at uniform density ((k - 1) / (pi r_k^2) for the box, relative variance 1 / (k - 2)), where counting it gives the
// k / (k - 1) of the textbook. The search stops at a largest radius; fewer than k photons there are counted all, over the disc
// of that radius, and the mixture is unbiased still: with n ~ Poisson, E = density (P(n >= k - 1) + P(n <= k - 2)). With k = 0
// the radius is fixed.
//
// What stays is the bias of the kernel's width: smooth irradiance blurs by kappa r^2 laplacian(E) (kappa = 1/8 box, 1/12
// Epanechnikov, 3/40 cone), and within r of an edge the part of the disc off the surface is missing (one half at the edge).
#pragma once

#include "framework/transport/bsdf.h"
#include "integrators/density_kernel.h"
#include "integrators/photons.h"

#include <memory>

namespace etendue {

struct GatherOptions {
  int k = 50;
  float radius = 0;  // metres; with k the largest radius of the search; 0: from the photons' own density
  Kernel kernel = Kernel::epanechnikov;
  bool side_test = true;  // refuse photons that arrived on another side than the one that is looked at
};

// Photons under a kernel: the first `count` of the neighbours, over a disc of squared radius `radius_squared`.
struct KernelDisc {
  std::size_t count = 0;
  float radius_squared = 0;

  float shape(Kernel kernel, float distance_squared) const { return kernel_shape(kernel, distance_squared / radius_squared); }
  float per_area() const { return radius_squared > 0 ? inv_pi / radius_squared : 0; }
};

// k nearest within `radius` (k > 0), or all within `radius`. `out` is the caller's buffer.
KernelDisc find_disc(const PointQuery& query, const vec3& position, int k, float radius, Neighbours& out);

class PhotonMap {
 public:
  // Takes the photons along a space-filling curve and builds `query` over them.
  void build(Photons photons, std::unique_ptr<PointQuery> query, const GatherOptions& options);

  // Radiance towards wo that photons of the given histories, with at most `max_scatterings` events behind them, make the
  // surface reflect.
  Rgb radiance(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, PhotonHistory histories, int max_scatterings) const;

 private:
  float automatic_radius() const;

  Photons photons_;
  std::unique_ptr<PointQuery> query_;
  GatherOptions options_;
  float radius_ = 0;
};

}  // namespace etendue
