// A cell of an experiment on claims: one claim, as one measurement found it on one scene.
#pragma once

#include "experiments/log/log.h"
#include "experiments/statistics/verdict.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

struct ClaimStatement {
  int id = 0;
  std::string claim, source, claimed;
  std::string reading = {};  // how the claim's words became intervals, and what else a reader must know
};

struct ClaimFigure {
  std::string quantity, text;
  FigureKind kind = FigureKind::factor;
  Measured value;
  bool judged = false;  // by what is expected; else the figure is only shown
  Expected expected = {};
};

// The cell is (scene, measurement, "claim-01", seed).
struct ClaimRecord final : KindRecord, ClaimStatement {
  static constexpr const char* type = "claim";

  std::vector<ClaimFigure> figures;
  std::vector<std::string> remarks;
  std::uint64_t disagreements = 0;

  std::string line() const override;
};

}  // namespace etendue
