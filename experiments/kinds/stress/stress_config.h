// The part of an experiment that runs methods on the scenes that break them: [[stress]] with remedies (docs/experiment-file.md
// has the keys). A cell is one row: all of its methods, under all seeds.
#pragma once

#include "experiments/config/config.h"
#include "experiments/config/method.h"
#include "experiments/kinds/stress/stress_figures.h"

#include <optional>

namespace etendue {

struct StressTrial {
  std::string name;  // of the remedy; "" for the method as it fails
  Method method;
};

struct StressRow {
  int id = 0;
  std::string failure, source, scene;
  const StressFigure* figure = nullptr;
  Expected fails = {}, holds = {};
  std::optional<std::uint64_t> samples = {};
  std::vector<StressTrial> trials = {};  // the first as it fails
};

struct StressChoice final : KindChoice {
  std::vector<StressRow> rows;
};

// Throws Error.
StressChoice read_stress(const ConfigNode& rows);

}  // namespace etendue
