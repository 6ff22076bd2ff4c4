// The part of an experiment that runs methods on the scenes that break them.
//
//   [[stress]]
//   id, failure, source   which failure, in words, and who described it or what computes it
//   scene                 builtin:NAME, or a file
//   figure                what is measured of the image (stress_figures.h)
//   method                { name, parameters… }: as it fails
//   expect                { fails = [low, high], holds = [low, high] }: the figure of it, and of a method that does not fail
//   samples               iterations; default: the experiment's budget
//   [[stress.remedies]]
//   name                  in words
//   change                { parameters… } put in the place of the method's, or
//   method                another method
//
// Beside them seeds, resolution and budget = { samples = N }. A cell is one row: all of its methods, under all seeds.
#pragma once

#include "experiments/config/config.h"
#include "experiments/config/method.h"
#include "experiments/kinds/claims/claim.h"
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
  Expected fails, holds;
  std::optional<std::uint64_t> samples;
  std::vector<StressTrial> trials;  // the first as it fails
};

struct StressChoice final : KindChoice {
  std::vector<StressRow> rows;
};

// Throws Error.
StressChoice read_stress(const ConfigNode& rows);

}  // namespace etendue
