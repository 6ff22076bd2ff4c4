// The part of an experiment that sweeps methods along what breaks them: [[stress]], each a hazard, with remedies, [sweep] and
// the columns of the matrix, `integrators` (docs/experiment-file.md has the keys). A cell is one (hazard, method) or (hazard,
// remedy), with all of its points under all seeds. A hazard with [stress.rows] has a second parameter: one method is swept
// along x for each value of y, and the cells are the rows of a heat map.
#pragma once

#include "experiments/config/config.h"
#include "experiments/config/method.h"
#include "experiments/kinds/stress/stress_figures.h"
#include "experiments/kinds/stress/stress_record.h"

#include <optional>

namespace etendue {

// The texts that stand for the parameter, and for what it lacks of one, in a hazard's scenes and in parameters of methods.
inline constexpr const char *sweep_variable = "{x}", *sweep_rest = "{1-x}";
// The text that stands for the second parameter.
inline constexpr const char* row_variable = "{y}";

// A method on a hazard, or one with a remedy.
struct StressTrial {
  std::string method;                     // as its column is called, or the structure
  std::string remedy = {};                // what mends it; "": nothing, and then the cell is one of the matrix
  std::string scene = {};                 // with {x}: the hazard's, or the one in its place for this method
  ConfigNode node = {};                   // { name, parameters… }, in which {x} may stand
  std::uint64_t samples = 1;              // iterations
  std::string inapplicable = {};          // why the hazard says nothing about it; "": it does
  std::optional<Expected> expected = {};  // the threshold, in x
  std::optional<double> y = {};           // of a hazard with a second parameter, which `scene` and `node` have already
};

struct StressHazard : HazardText {
  std::string scene;  // with {x}
  const StressFigure* figure = nullptr;
  std::vector<StressTrial> trials = {};

  bool of_structures() const { return figure->of_structure != nullptr; }
};

struct StressChoice final : KindChoice {
  double factor = 1.25;  // thresholds lie between points no further apart
  std::vector<StressHazard> hazards;
};

// `sweep` may be null. Throw Error.
StressChoice read_stress(const ConfigNode& hazards, const ConfigNode* sweep, const ConfigNode& integrators,
                         std::uint64_t samples);

std::string with_variable(const std::string& text, double x);  // {x} and {1-x} replaced
Method method_at(const StressHazard& hazard, const StressTrial& trial, double x);

}  // namespace etendue
