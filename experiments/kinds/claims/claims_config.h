// The part of an experiment that names claims: [[claims]] with their measures, and timing (docs/experiment-file.md has the
// keys). A cell is one (claim, measurement, scene).
#pragma once

#include "experiments/config/config.h"
#include "experiments/kinds/claims/claim_record.h"
#include "experiments/kinds/claims/measurement.h"

#include <map>

namespace etendue {

struct ClaimMeasure {
  const Measurement* measurement = nullptr;
  std::vector<std::string> scenes;
  std::map<std::string, Expected> expect;
  bool large = false;
};

struct Claim : ClaimStatement {
  std::vector<ClaimMeasure> measures = {};
};

struct ClaimsChoice final : KindChoice {
  int resolution = 256;  // about its square of rays of each kind
  int repetitions = 9;   // interleaved
  bool large = true;     // with the measures that take gigabytes and minutes
  std::vector<Claim> rows;
};

// Reads the values of the keys `claims` and `timing` (may be null). Throws Error.
ClaimsChoice read_claims(const ConfigNode& claims, const ConfigNode* timing);

}  // namespace etendue
