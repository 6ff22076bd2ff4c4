#include "experiments/config/config_keys.h"
#include "experiments/kind.h"
#include "experiments/kinds/images/images_run.h"
#include "experiments/report/tables.h"

namespace etendue {

namespace {

class ImagesKind final : public ExperimentKind {
 public:
  std::vector<std::string> keys() const override { return {}; }
  std::vector<std::string> measures() const override {
    return measured_code({"experiments/kinds/images", "experiments/kinds/structures"});
  }
  std::string beside() const override { return "[[integrators]]"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    const Location where{config.path};
    const auto find = [&](const char* key) { return find_key(root, key); };
    if (const auto* n = find("accels")) config.accels = read_accels(*n, OwnLabels::allowed);
    const auto* methods = find("integrators");
    if (methods) config.integrators = read_integrators(*methods, OwnLabels::allowed);
    require_scenes(config);
    const std::vector<std::string> scene_names = mapped(config.scenes, &SceneChoice::name);
    if (const auto* n = find("regions")) config.regions = read_regions(*n, scene_names);
    const PredictionContext context{scene_names, config.integrators, config.regions, config.metrics};
    if (const auto* n = find("predictions")) config.predictions = read_predictions(*n, context);
    if (!methods && !config.structures)
      throw Error(where, "no integrators; expected [[integrators]] tables (or structures = true, or [dynamic])");
    if (methods && !find("budget")) throw Error(where, "no budget; expected budget = { time = \"60s\" } or { samples = 256 }");
    if (const auto* n = find("elsewhere")) config.elsewhere = read_elsewhere(*n);
  }

  std::vector<std::string> quick(const ConfigNode& root) const override {
    std::vector<std::string> assignments{"seeds=1", "budget={ time = \"0.3s\" }", "resolution=[64, 64]"};
    if (const ConfigNode* timing = find_key(root, "structures"); timing && read_structures(*timing))
      assignments.emplace_back("structures={ resolution = 64, repetitions = 1 }");
    return assignments;
  }

  std::vector<Cell> cells(const ExperimentConfig& config) const override { return make_matrix(config, config.integrators); }
  std::string effort(const ExperimentConfig& config) const override { return "at most " + config.budget.text(); }

  RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction& compute) const override {
    return execute_images(plan, observer, compute);
  }
  std::string summary(const RunLog& log) const override { return summary_table(log); }
};

}  // namespace

const ExperimentKind& images_kind() { return the_kind<ImagesKind>(); }

}  // namespace etendue
