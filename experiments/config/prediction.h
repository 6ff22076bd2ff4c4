// Predictions that an experiment makes of the errors in its images before it runs, whose theory or figure that is, and of which
// cells: [[predictions]] (docs/experiment-file.md has the keys). A prediction is of the exponent at which an error falls over
// x, of the ratio of two methods' RMSE at the end of their runs, or of the bias of each image. Where x is "records" and a cache
// tells where they are, those in the region count.
//
// The log keeps predictions and their regions in one line. The last such line counts, so that a window can be moved without
// running anything again.
#pragma once

#include "experiments/config/config_tree.h"
#include "experiments/config/elsewhere.h"
#include "experiments/config/expected.h"
#include "experiments/config/method.h"
#include "experiments/config/regions.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct Prediction {
  enum class Quantity : std::uint8_t { exponent, ratio, bias };
  enum class Model : std::uint8_t { power, plateau };

  Quantity quantity = Quantity::exponent;
  std::string method, over, scene, region;  // scene empty: every one; region empty: the whole image
  std::optional<Expected> expected;         // empty: a ratio that is measured only
  std::string source;
  // An exponent is fitted to these.
  std::string metric = "mse", x = "iterations";
  bool across = false;  // the points are configurations
  double from = 0, to = endless;
  Model model = Model::power;

  bool is_ratio() const { return quantity == Quantity::ratio; }
  bool is_exponent() const { return quantity == Quantity::exponent; }
  bool needs_images() const { return is_exponent() && (metric == "bias2" || metric == "variance"); }
  bool operator==(const Prediction&) const = default;
};

// Whether a method's label has the name and all of the parameters that a prediction's `method` has.
bool selects(const std::string& method, const std::string& label);

struct PredictionContext {
  const std::vector<std::string>& scenes;
  const std::vector<Method>& integrators;
  const std::vector<RegionChoice>& regions;
  const std::vector<std::string>& metrics;
};
// Throws Error.
std::vector<Prediction> read_predictions(const ConfigNode& node, const PredictionContext& context);

// Holds what is stated before anything runs.
struct StatedRecord {
  static constexpr const char* line_type = "predictions";  // in the log

  std::vector<Prediction> predictions;
  std::vector<RegionChoice> regions;
  std::vector<ElsewhereFigure> elsewhere = {};
  std::map<std::string, std::string> labels = {};  // the experiment's own labels of structures and methods, by full names

  // Whether what is stated of a scene and a region (empty: of all) is of this scene.
  bool concerns(const Prediction& prediction, const std::string& scene) const;
  bool empty() const { return predictions.empty() && regions.empty() && elsewhere.empty() && labels.empty(); }
  void merge(const StatedRecord& other);  // adds what it does not hold
};

}  // namespace etendue
