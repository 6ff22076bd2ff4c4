// A cell of an experiment on claims: one claim, as one measurement found it on one scene. Or one row of the catalogue of
// failures.
#pragma once

#include "experiments/config/cell_name.h"
#include "experiments/log/measured.h"
#include "framework/io/whole_file.h"

#include <cstdint>
#include <optional>
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

// Of a row of the catalogue of failures (experiments/stress): its first figure is the failing method's, the others are those of
// its remedies, with their names.
struct StressNote {
  double holds_low = 0, holds_high = 0;  // the figure of a method that does not fail
  std::vector<std::string> methods;      // of the figures
  std::string picture;                   // beside the log: truth, then each method
  FileStamp picture_stamp = {};
};

struct ClaimRecord {
  CellName cell;  // scene, measurement, "claim-01", seed
  std::string manifest, status, error;
  int id = 0;
  std::string claim, source, claimed;
  std::string reading;  // how the claim's words became intervals, and what else a reader must know
  std::vector<ClaimFigure> figures;
  std::vector<std::string> remarks;
  std::uint64_t disagreements = 0;
  std::optional<StressNote> stress;
};

// As a line of runs.jsonl, and back.
std::string to_json_line(const ClaimRecord& record);
ClaimRecord read_claim_line(const std::string& line);

}  // namespace etendue
