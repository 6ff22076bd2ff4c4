// What the log holds of an experiment on point or ball structures: one line per cell, which is one set at one size, with all
// structures.
#pragma once

#include "experiments/config/cell_name.h"
#include "experiments/log/measured.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

struct SearchFigure {
  std::string structure;
  std::string measure;   // points: "build", "within", "nearest", "memory"; balls: "insert", "covering", "memory"
  double parameter = 0;  // of within and nearest: number of neighbours
  Measured value;        // seconds per point, per query or per ball; memory: bytes per point or ball
  double found = 0;      // of queries: how many each found on the mean
};

struct SearchRecord {
  CellName cell;  // its "scene" is the set, its "integrator" the size
  std::string manifest;
  std::string status, error;  // as of a CellRecord
  std::string kind;           // "points" or "balls"
  std::string set;            // without the variation
  std::string varies;         // "contrast", "spread" or "" where the set has no such parameter
  double variation = 0;
  std::uint64_t count = 0;
  std::uint64_t checked = 0, disagreements = 0;  // answers compared, and those that differed
  std::vector<SearchFigure> figures;
};

std::string to_json_line(const SearchRecord& record);
// Of a line's text; throws what the JSON library throws.
SearchRecord read_search_line(const std::string& line);

}  // namespace etendue
