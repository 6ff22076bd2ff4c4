// Chi-squared progressive photon mapping ([Lin2020]).
//
// A pixel's radius shrinks only when a test finds its photons uneven: see integrators/progressive/chi_squared_radius.h for the
// rule and its rate (MSE ~ n^(-2/3) where light is uneven, n^-1 where not), and integrators/progressive/progressive.h for the
// rest.
#pragma once

#include "integrators/progressive/progressive.h"

namespace etendue {

struct CppmParams : ProgressiveParams {
  CppmParams() { lobe_tails = "gathered"; }

  std::string hypothesis = "even";
  float beta = 1.1f;
};

template <class Visitor>
void describe(Visitor& v, CppmParams& p) {
  v.choice("hypothesis", p.hypothesis, {"even", "odd"}, "that is tested: no change over the disc, or none but slopes");
  v.number("beta", p.beta, 1, 100, "", "growth of the photons that a test waits for, by each refusal; 1.5625 in the paper");
  describe_progressive(v, p);
}

IntegratorEntry cppm_entry();

}  // namespace etendue
