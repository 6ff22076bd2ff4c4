// experiment.toml → ExperimentConfig: everything checked, with file:line:col, before anything runs.
// docs/experiment-file.md lists the keys.
#pragma once

#include "experiments/config/budget.h"
#include "experiments/config/elsewhere.h"
#include "experiments/config/method.h"
#include "experiments/config/prediction.h"
#include "experiments/config/regions.h"
#include "framework/core/isa.h"
#include "framework/core/vec.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct SceneChoice {
  std::string name;  // as the experiment writes it, and as the log names it
  std::string path;  // what load_scene is given
  Location where;
};

struct ReferenceChoice {
  enum class Kind : std::uint8_t { automatic, exact, samples, file };
  Kind kind = Kind::automatic;
  std::uint64_t samples = 0;       // per pixel and estimator; 0: the default, or what the cache has
  std::vector<std::string> files;  // one a scene
  Location where;

  ReferenceChoice of_scene(std::size_t scene) const {
    return kind == Kind::file ? ReferenceChoice{kind, samples, {files.at(scene)}, where} : *this;
  }
};

// How structures are compared (kinds/structures/accel_comparison.h).
struct StructureTiming {
  int resolution = 256;          // about resolution^2 rays of each kind
  int repetitions = 3;           // interleaved; medians and quartiles are reported
  int threads = 1;               // of the parallel build
  std::uint64_t check_rays = 0;  // further rays, aimed at vertices and edges, in four scales and offsets
  double budget_s = 10;          // for each structure, without checks: beyond it fewer rays and repetitions, or none
  std::vector<Isa> isas = {};    // each structure with each, named where there are several; empty: the chosen one alone
};

class ExperimentKind;  // experiments/kind.h

// Holds what the keys of a kind say. Kinds derive their own.
struct KindChoice {
  virtual ~KindChoice() = default;
};

struct ExperimentConfig {
  std::string path, title, text;  // text: of the file, before overrides
  std::vector<SceneChoice> scenes;
  std::vector<Method> accels, integrators;
  std::vector<std::uint64_t> seeds;
  Budget budget;
  ReferenceChoice reference;
  std::vector<std::string> metrics;
  bool confidence = false;
  std::vector<RegionChoice> regions;
  std::vector<Prediction> predictions;
  std::vector<ElsewhereFigure> elsewhere;
  std::optional<ivec2> resolution;
  std::optional<int> threads;
  std::optional<StructureTiming> structures;
  std::vector<std::string> table_formats;
  const ExperimentKind* kind = nullptr;
  std::shared_ptr<const KindChoice> choice;  // null: the kind has no keys beyond the above
  std::string hash;  // of all that changes a result: neither comments nor title, labels, threads, outputs, predictions nor
                     // figures from elsewhere
};

template <class Choice>
const Choice& choice_of(const ExperimentConfig& config) {
  return dynamic_cast<const Choice&>(*config.choice);
}

struct ConfigOptions {
  bool quick = false;
  std::vector<std::string> overrides;  // key=value, applied in order, after [quick]
};

// Throw Error.
ExperimentConfig load_config(const std::string& path, const ConfigOptions& options = {});
ExperimentConfig parse_experiment(const std::string& text, const std::string& path, const ConfigOptions& options = {});

}  // namespace etendue
