// The radius of a progressive gather, from pass to pass.
//
// A progressive photon mapper renders pass after pass of fresh photons, estimates each pixel's radiance by a kernel of radius
// r_i in pass i, and shows the mean of the estimates. The variance averages out. The bias is proportional to r_i^2, so the
// radius must shrink, but slowly enough that the mean's variance, of order sum r_i^-2 / n^2, vanishes too. The methods differ
// only in the rule for r_i:
//
//   FixedRadius        r_i = r_1                                            the noise goes, the bias stays
//   NearestRadius      the k-th nearest photon of the pass itself           [Jensen1996]; likewise
//   MemorylessRadius   a sequence that looks at nothing                     [Knaus2011]
//   SharedStatistics   by the photons a pixel has gathered so far           [Hachisuka2008], [Hachisuka2009]
//   AdaptiveBandwidth  by the pixel's estimated variance and curvature      [Kaplanyan2013], adaptive_bandwidth.h
//   ChiSquaredRadius   when a test finds the photons uneven                 [Lin2020], chi_squared_radius.h
//
// The flux that [Hachisuka2008] (section 4.2) corrects at each shrinking is this mean: tau_{i+1} = (tau_i + phi_i) r_{i+1}^2 /
// r_i^2, so that tau / r^2 grows by phi_i / r_i^2, which is pi times the pass's own estimate.
//
// A policy is a plain class without virtual functions that satisfies RadiusPolicy. A pixel's state is touched by one thread at
// a time; it depends on that pixel's earlier passes alone.
#pragma once

#include "framework/core/elementary.h"
#include "integrators/photons/photon_gather.h"

#include <concepts>
#include <vector>

namespace etendue {

// r_1 per pixel, from the density of a pilot pass (integrators/progressive/progressive.h).
using InitialRadii = std::vector<float>;

// Where, and in which pass, a radius is needed.
struct GatherSite {
  const RenderContext& context;
  std::size_t pixel;
  std::uint32_t pass;  // from 0
  const PhotonMap& map;
  const GatherPoint& at;
};

// The kernel's radius, and the radius, at least as large, within which the policy observes photons.
struct GatherDisc {
  float radius, reach;

  explicit GatherDisc(float r) : radius(r), reach(r) {}
  GatherDisc(float r, float observed) : radius(r), reach(std::max(r, observed)) {}
};

// Gathers what a policy learns from a pixel's photons in one pass: begin() at each point that the camera path gathers at, then
// add() for each photon within reach. This one counts.
struct PhotonCount {
  std::uint32_t photons = 0;

  void begin(const GatherDisc& /*disc*/, const GatherPoint& /*at*/, const Rgb& /*throughput*/) {}
  void add(const Rgb& /*reflected*/, const vec3& /*offset*/, float /*distance_squared*/) { ++photons; }
};

// update(): once per pixel and pass in which the camera path gathered at all.
template <class P>
concept RadiusPolicy = requires(P& p, const P& c, const GatherSite& site, typename P::Observed observed,
                                const GatherDisc& disc) {
  { c.disc(site) } -> std::same_as<GatherDisc>;
  p.update(std::size_t{0}, std::uint32_t{0}, observed);
  observed.begin(disc, site.at, Rgb(1));
  observed.add(Rgb(0), vec3(0), 0.5f);
};

class FixedRadius {
 public:
  using Observed = PhotonCount;

  explicit FixedRadius(InitialRadii radii) : radii_(std::move(radii)) {}
  GatherDisc disc(const GatherSite& site) const { return GatherDisc(radii_[site.pixel]); }
  void update(std::size_t, std::uint32_t, const Observed&) {}

 private:
  InitialRadii radii_;
};

// The k-th photon, which sets the radius, is left out of the gather: see integrators/photons/photon_gather.h for why.
class NearestRadius {
 public:
  using Observed = PhotonCount;

  NearestRadius(int k, float r_max) : k_(k), r_max_(r_max) {}
  GatherDisc disc(const GatherSite& site) const {
    const float r = site.map.distance_to(site.context, k_, site.at, r_max_);
    return GatherDisc(r < r_max_ ? std::nextafter(r, 0.0f) : r);
  }
  void update(std::size_t, std::uint32_t, const Observed&) {}

 private:
  int k_;
  float r_max_;
};

// r_i of the memoryless sequence, i from 0, over r_0: r_{i+1}^2 / r_i^2 = (i + alpha) / (i + 1) with i from 1 ([Knaus2011]). In
// closed form r_n^2 = Gamma(n + alpha) / (Gamma(1 + alpha) Gamma(n + 1)), which tends to n^(alpha-1) / Gamma(1 + alpha), with n
// = i + 1 passes.
inline float memoryless_shrinkage(std::uint32_t pass, double alpha) {
  const double n = pass + 1.0;
  return static_cast<float>(math::exp(0.5 * (math::lgamma(n + alpha) - math::lgamma(1 + alpha) - math::lgamma(n + 1))));
}

// MSE exponent of radii that shrink as r^2 ~ n^(alpha - 1): variance ~ n^-alpha against bias^2 ~ n^(-2 (1 - alpha))
// ([Kaplanyan2013]; alpha = 2/3 balances them). alpha = 1: the radius stays, and so does the bias.
inline double progressive_exponent(double alpha) { return alpha < 1 ? -std::min(alpha, 2 * (1 - alpha)) : -1; }

class MemorylessRadius {
 public:
  using Observed = PhotonCount;

  MemorylessRadius(InitialRadii radii, double alpha) : radii_(std::move(radii)), alpha_(alpha) {}
  // Once per pass, before its gathers.
  void begin_pass(std::uint32_t pass) { shrinkage_ = memoryless_shrinkage(pass, alpha_); }
  GatherDisc disc(const GatherSite& site) const { return GatherDisc(radii_[site.pixel] * shrinkage_); }
  void update(std::size_t, std::uint32_t, const Observed&) {}

 private:
  InitialRadii radii_;
  double alpha_;
  float shrinkage_ = 1;
};

// N_{i+1} = N_i + alpha M_i and r_{i+1}^2 / r_i^2 = N_{i+1} / (N_i + M_i) ([Hachisuka2008] section 4.1, M_i the photons found
// in pass i): the density within the radius is kept while a share alpha of each pass's photons is. [Hachisuka2009] shares N and
// r between all points that a pixel sees.
class SharedStatistics {
 public:
  using Observed = PhotonCount;

  SharedStatistics(InitialRadii radii, double alpha) : radii_(std::move(radii)), counts_(radii_.size(), 0), alpha_(alpha) {}
  GatherDisc disc(const GatherSite& site) const { return GatherDisc(radii_[site.pixel]); }
  void update(std::size_t pixel, std::uint32_t, const Observed& observed) {
    if (observed.photons == 0) return;
    const double m = observed.photons, kept = counts_[pixel] + alpha_ * m;
    radii_[pixel] *= static_cast<float>(std::sqrt(kept / (counts_[pixel] + m)));
    counts_[pixel] = kept;
  }

 private:
  InitialRadii radii_;
  std::vector<double> counts_;  // N
  double alpha_;
};

static_assert(RadiusPolicy<FixedRadius> && RadiusPolicy<NearestRadius> && RadiusPolicy<MemorylessRadius> &&
              RadiusPolicy<SharedStatistics>);

}  // namespace etendue
