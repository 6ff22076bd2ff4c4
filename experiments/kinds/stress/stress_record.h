// A cell of the failure map as it was measured: a method along a hazard's parameter. The cell is (scene at the harmless end,
// "stress-01", method or "method: remedy", 1).
#pragma once

#include "experiments/kinds/stress/stress_sweep.h"
#include "experiments/log/log.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

// A point of the curve, with what else its images say.
struct StressPoint : SweepPoint {
  double bias = 0, bias_error = 0;  // relative error of the mean over seeds of the image's mean, and its standard error
  double peak = 0;                  // brightest pixel of any seed over the reference's brightest
  // Each has a value for each seed: the tail index of the image (stress_figures.h), and iterations and time of the first
  // checkpoint at which relMSE is below sane_relmse. Where none is, they are those of the last one, negative.
  std::vector<double> tails = {}, sane_iterations = {}, sane_s = {};
  // The share of pixels whose error is beyond twice the standard error that the method states, on the mean over seeds; empty:
  // it states none.
  std::optional<double> beyond_stated = {};
};

// An image is sane where its error is below half of the reference, as a root mean square. A black one is not: relMSE is
// about 1.
inline constexpr double sane_relmse = 0.25;

// Holds what records say of their hazard.
struct HazardText {
  int id = 0;
  std::string hazard, failure, source;        // hazard: the name of the matrix' row
  std::string parameter, unit;                // what x is, and its unit ("": a ratio or a number)
  std::string second = {}, second_unit = {};  // what y is, of a heat map, and its unit; empty: there is none
  SweepRange range = {};
  Expected holds = {};  // the figure of a method that does not fail
};

struct StressRecord final : KindRecord, HazardText {
  static constexpr const char* type = "stress";

  std::string figure, figure_text;
  std::string column, remedy;  // the method's column of the matrix; what mends it: "" for the matrix' own cells
  std::string method;          // with its parameters at the harmless end
  Parameters parameters = {};  // these by name
  std::string inapplicable;    // why nothing was measured; "": it was
  std::optional<double> y;     // of a row of a heat map; empty: there is no second parameter
  bool of_structure = false;
  std::optional<double> expected_low, expected_high;  // of the threshold, in x; infinite ends are left out
  bool is_expected = false;
  std::vector<StressPoint> points;           // ascending in t
  std::vector<std::string> references = {};  // the scenes whose references points are measured against; older lines lack them
  std::string before, after;                 // commands that repeat the points on both sides of the threshold
  std::uint64_t disagreements = 0;           // wrong answers of a structure
  std::string picture;                       // beside the log: reference and image before, reference and image after
  FileStamp picture_stamp;

  std::vector<SweepPoint> curve() const { return {points.begin(), points.end()}; }
  std::string line() const override;
  // In an older line the scene of the harmless end stands for all.
  bool uses_reference_of(const std::string& scene) const override {
    return contains(references, scene) || (references.empty() && !of_structure && !points.empty() && cell.scene == scene);
  }
  File file() override { return {&picture, &picture_stamp}; }
};

}  // namespace etendue
