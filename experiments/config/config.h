// experiment.toml → ExperimentConfig: everything checked, with file:line:col, before anything runs.
//
//   title       text; default: the file's name
//   scenes      names or paths (beside the TOML file first, then in the working directory)
//   accels      ray structures: names or tables { name, parameters… }; "all": every one that is built in. Default binned-sah
//   integrators methods: tables { name, parameters… } or names; a parameter may be an array: one method for each value
//   seeds       how many (1, 2, …, N) or an array of them
//   budget      { time = "60s", samples = N, error = E, checkpoints = "log" | "sqrt2" | "linear:N" }: the first limit reached
//               ends a cell; `error` (a relmse) needs a limit beside it, for it may never be reached
//   reference   "auto" (default: the closed form where the scene has one, else cached or rendered), "exact", { samples = N }
//               or { file = "ref.exr" }
//   metrics     default: all
//   confidence  true: hold what methods take their own error to be against a closed form (confidence.h)
//   resolution  [w, h]; default: the scene's
//   threads     default: the machine's; `--threads` wins
//   structures  true or { resolution, repetitions, check_rays, budget = "10s", isa = ["avx2", "avx512"] }: also time every
//               structure on every scene
//   regions     [[regions]]: parts of a scene's image that every checkpoint judges by themselves (regions.h)
//   predictions [[predictions]]: the exponents at which errors fall there, or the ratios of methods' errors, that somebody
//               expects (prediction.h); the report measures and judges them
//   outputs     { tables = ["md", "csv", "tex"] }
//   quick       any of the keys above, put in their place by `--quick`
//
// or, instead of integrators, the keys of another kind of experiment:
//
//   dynamic         { frames, motions, policies, … }: scenes that move (kinds/animation/animation.h)
//   points, records what finds points or records (kinds/search/search_config.h)
//   claims, timing  statements and what measures them (kinds/claims/claims_config.h)
//   stress          methods on the scenes that break them (kinds/stress/stress_config.h)
#pragma once

#include "experiments/config/budget.h"
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
  std::uint64_t samples = 0;  // per pixel and estimator; 0: the default, or what the cache has
  std::string file;
  Location where;
};

struct StructureTiming {
  int resolution = 256;
  int repetitions = 3;
  std::uint64_t check_rays = 0;  // as in ComparisonOptions
  double budget_s = 10;
  std::vector<Isa> isas = {};
};

class ExperimentKind;  // experiments/kind.h

// What the keys of a kind say. Kinds derive their own.
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
  std::optional<ivec2> resolution;
  std::optional<int> threads;
  std::optional<StructureTiming> structures;
  std::vector<std::string> table_formats;
  const ExperimentKind* kind = nullptr;
  std::shared_ptr<const KindChoice> choice;  // null: the kind has no keys beyond the above
  std::string hash;  // of all that changes a result: neither comments nor title, threads, outputs or predictions
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
