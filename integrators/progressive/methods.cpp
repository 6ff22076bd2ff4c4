#include "integrators/progressive/methods.h"

#include "integrators/progressive/adaptive_bandwidth.h"
#include "integrators/progressive/chi_squared_radius.h"
#include "integrators/progressive/progressive.h"

namespace etendue {

namespace {

constexpr double bytes_a_pixel = 60;  // of statistics

Bias vanishing_below_one(float alpha) { return alpha < 1 ? Bias::consistent : Bias::biased; }

// The policy is made of the initial radii and of `rule`.
template <class Policy, class Rule>
std::unique_ptr<Integrator> make(const ProgressiveParams& params, VisiblePoints points, const Rule& rule,
                                 Expectation expected) {
  return std::make_unique<ProgressivePhotonMapping<Policy>>(
      params, points, [rule](InitialRadii radii) { return Policy(std::move(radii), rule); }, std::move(expected));
}

struct SharedStatisticsParams : ProgressiveParams {
  float alpha = 0.7f;
};

template <class Visitor>
void describe(Visitor& v, SharedStatisticsParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "", "share of each pass's photons that is kept; 1: the radius stays");
  describe_progressive(v, p);
}

struct SppmParams : SharedStatisticsParams {
  SppmParams() {
    photons_per_pixel = 0;
    neighbours = 0;
  }
};

struct PpmParams : SharedStatisticsParams {
  int points = 4;

  PpmParams() { further_paths = 0; }  // as published: what its fixed points see is all
};

template <class Visitor>
void describe(Visitor& v, PpmParams& p) {
  v.integer("points", p.points, 1, 65536, "points", "visible points per pixel");
  describe(v, static_cast<SharedStatisticsParams&>(p));
}

struct MemorylessParams : ProgressiveParams {
  float alpha = 2.0f / 3.0f;
};

template <class Visitor>
void describe(Visitor& v, MemorylessParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "", "the larger, the slower the radius shrinks; 1: it stays");
  describe_progressive(v, p);
}

struct AppmParams : ProgressiveParams {};

template <class Visitor>
void describe(Visitor& v, AppmParams& p) {
  describe_progressive(v, p);
}

enum class Hypothesis : std::uint8_t { even, odd };
constexpr auto names_of(Hypothesis) { return std::array{"even", "odd"}; }

struct CppmParams : ProgressiveParams {
  CppmParams() { lobe_tails = LobeTails::gathered; }

  Hypothesis hypothesis = Hypothesis::even;
  float beta = 1.1f;
};

template <class Visitor>
void describe(Visitor& v, CppmParams& p) {
  v.choice("hypothesis", p.hypothesis, "that is tested: no change over the disc, or none but slopes");
  v.number("beta", p.beta, 1, 100, "", "growth of the photons that a test waits for, by each refusal; 1.5625 in the paper");
  describe_progressive(v, p);
}

}  // namespace

IntegratorEntry ppm_entry() {
  return integrator_entry<PpmParams>(
      "ppm", "progressive photon mapping: fixed visible points, statistics of each", [](const PpmParams& p) {
        return make<SharedStatistics>(
            p, {static_cast<std::uint32_t>(p.points)}, p.alpha,
            {Bias::biased, progressive_exponent(p.alpha), 0.02,
             "blur and loss at edges vanish with the radius [Hachisuka2008]; the fixed points' aliasing stays"});
      },
      300);
}

IntegratorEntry sppm_entry() {
  return integrator_entry<SppmParams>(
      "sppm", "stochastic progressive photon mapping: new visible points in every pass, statistics shared by pixel",
      [](const SppmParams& p) {
        return make<SharedStatistics>(p, {}, p.alpha,
                                      {vanishing_below_one(p.alpha), progressive_exponent(p.alpha), 0.02,
                                       "blur by the radius and loss at edges, which vanish with it [Hachisuka2009]"});
      },
      bytes_a_pixel);
}

IntegratorEntry ppm_memoryless_entry() {
  return integrator_entry<MemorylessParams>(
      "ppm-memoryless", "progressive photon mapping by a fixed sequence of radii", [](const MemorylessParams& p) {
        return make<MemorylessRadius>(p, {}, p.alpha,
                                      {vanishing_below_one(p.alpha), progressive_exponent(p.alpha), 0.02,
                                       "blur by the radius and loss at edges, which vanish with it [Knaus2011]"});
      },
      bytes_a_pixel);
}

IntegratorEntry appm_entry() {
  return integrator_entry<AppmParams>(
      "appm", "adaptive progressive photon mapping: the radius that variance and curvature ask for", [](const AppmParams& p) {
        return make<AdaptiveBandwidth>(
            p, {}, p.kernel, {Bias::consistent, -2.0 / 3, 0.02, "bias and noise in balance, both vanish [Kaplanyan2013]"});
      },
      bytes_a_pixel);
}

IntegratorEntry cppm_entry() {
  return integrator_entry<CppmParams>(
      "cppm", "chi-squared progressive photon mapping: the radius shrinks where photons prove uneven", [](const CppmParams& p) {
        return make<ChiSquaredRadius>(
            p, {}, ChiSquaredRadius::Rules{p.beta, p.hypothesis == Hypothesis::odd},
            {Bias::consistent, -2.0 / 3, 0.02, "blur and loss at edges, until the test sees them [Lin2020]"});
      },
      bytes_a_pixel);
}

}  // namespace etendue
