// A cell of an experiment on claims: one claim, as one measurement found it on one scene.
#pragma once

#include "experiments/log/log.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

// Tells which value means "no effect": 1 for a factor, infinity for a time in seconds, none for a plain figure.
enum class FigureKind : std::uint8_t { factor, time, plain };

struct ClaimFigure {
  std::string quantity, text;
  FigureKind kind = FigureKind::factor;
  Measured value;
  bool judged = false;  // by the expected interval; else the figure is only shown
  double expected_low = 0, expected_high = 0;
};

// The cell is (scene, measurement, "claim-01", seed).
struct ClaimRecord : KindRecord {
  int id = 0;
  std::string claim, source, claimed;
  std::string reading;  // how the claim's words became intervals, and what else a reader must know
  std::vector<ClaimFigure> figures;
  std::vector<std::string> remarks;
  std::uint64_t disagreements = 0;

  std::string line() const override;
};

// Throws what the JSON library throws.
ClaimRecord read_claim_record(const Json& json);

}  // namespace etendue
