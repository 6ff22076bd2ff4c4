// Errors that others measured and that cannot be measured here: other programs, other machines. They enter as data,
// [[elsewhere]] (docs/experiment-file.md has the keys), with their source, and the report draws them as such beside what was
// measured.
#pragma once

#include "experiments/config/config_tree.h"

#include <string>
#include <vector>

namespace etendue {

struct ElsewhereFigure {
  std::string scene, program, method, metric = "relmse", machine, date, source;
  double time_s = 0, error = 0;

  bool of_scene(const std::string& name) const;
  bool operator==(const ElsewhereFigure&) const = default;
};

// Throws Error. The scenes need not be the experiment's: figures are of whatever it is run over.
std::vector<ElsewhereFigure> read_elsewhere(const ConfigNode& node);

}  // namespace etendue
