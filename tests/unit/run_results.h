// The results of a run, without what a clock touches: two runs of one experiment agree in it to the bit.
#pragma once

#include "experiments/log/log.h"

#include <fmt/format.h>
#include <map>
#include <string>

namespace etendue {

// The results of each cell.
inline std::map<std::string, std::string> results(const RunLog& log) {
  std::map<std::string, std::string> text;
  for (const CheckpointRecord& c : log.checkpoints) {
    std::string& line = text[c.cell.key()];
    line += std::to_string(c.iterations);
    for (const auto& [name, value] : c.metrics) line += fmt::format(" {}={}", name, value);  // all digits
    for (const auto& [name, value] : c.counters) line += " " + name + "=" + std::to_string(value);
    line += "\n";
  }
  for (const CellRecord& c : log.cells) text[c.cell.key()] += c.status + " " + c.image + " " + c.image_hash + " " + c.bias;
  return text;
}

}  // namespace etendue
