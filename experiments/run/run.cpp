#include "experiments/run/run.h"

#include "experiments/kind.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

namespace etendue {

Scene load_choice(const RunPlan& plan, const SceneChoice& choice, RunObserver& observer) {
  Scene scene = load_scene(choice.path, choice.where, plan.reading);
  for (const std::string& warning : scene.warnings) {
    const bool named = warning.starts_with(choice.name + ":");
    observer.narrate("warning: " + (named ? warning : choice.name + ": " + warning));
  }
  return scene;
}

void narrate_skipped(const RunPlan& plan, std::size_t skipped, RunObserver& observer) {
  if (skipped > 0)
    observer.narrate(fmt::format("{}: {} of {} cells are done already", plan.directory, skipped, plan.cells.size()));
}

RunSummary execute_run(const RunPlan& plan, RunObserver& observer, const CellFunction& compute) {
  return plan.config.kind->run(plan, observer, compute);
}

}  // namespace etendue
