// Multiple importance sampling of direct light ([Veach1995]): the power and the balance heuristic.
#pragma once

#include "framework/core/check.h"
#include "framework/core/lanes.h"

#include <cstdint>
#include <string>

namespace etendue {

// How light sampling and BSDF sampling share the work ([Veach1995]): by the power heuristic (beta = 2) or the balance
// heuristic, or one of them alone. Lights that no ray can hit (point, spot, directional) are sampled in every mode.
enum class MisMode : std::uint8_t { power, balance, light, bsdf };

// The mode that a checked parameter names.
inline MisMode parse_mis(const std::string& name) {
  if (name == "power") return MisMode::power;
  if (name == "balance") return MisMode::balance;
  if (name == "light") return MisMode::light;
  CHECK_EQ(name, "bsdf");
  return MisMode::bsdf;
}

// Weight of the strategy with density `mine` where another has `other`.
template <class F>
F mis_weight(MisMode mode, F mine, F other) {
  if (mode == MisMode::balance) return mine / (mine + other);
  return select(mine > 1e18f, F(1.0f), mine * mine / (mine * mine + other * other));
}

// Weight of emission found by a BSDF sample of density pdf_bsdf (not from a delta lobe) where light sampling has pdf_light.
inline float emission_weight(MisMode mode, float pdf_bsdf, float pdf_light) {
  if (mode == MisMode::light) return 0;
  if (mode == MisMode::bsdf) return 1;
  return mis_weight(mode, pdf_bsdf, pdf_light);
}

}  // namespace etendue
