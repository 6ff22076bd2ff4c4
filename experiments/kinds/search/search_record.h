// What the log holds of an experiment on point or record structures: one line per cell, which is one set at one size, with all
// structures.
#pragma once

#include "experiments/log/log.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

struct SearchFigure {
  std::string structure;
  std::string measure;   // points: "build", "within", "nearest", "memory"; records: "insert", "covering", "memory"
  double parameter = 0;  // of within and nearest: number of neighbours
  Measured value;        // seconds per point, per query or per record; memory: bytes per point or record
  double found = 0;      // of queries: how many each found on the mean
};

// The cell's "scene" is the set, its "integrator" the size.
struct SearchRecord final : KindRecord {
  static constexpr const char* type = "search";

  std::string kind;    // "points" or "records"
  std::string set;     // without the variation
  std::string varies;  // "contrast", "spread" or "" where the set has no such parameter
  double variation = 0;
  std::uint64_t count = 0;
  std::uint64_t checked = 0, disagreements = 0;  // answers compared, and those that differed
  std::vector<SearchFigure> figures;

  std::string line() const override;
};

}  // namespace etendue
