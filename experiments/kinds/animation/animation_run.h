// The run of an experiment on change over time: as execute_run, for cells that are animations.
#pragma once

#include "experiments/run/run.h"

namespace etendue {

RunSummary execute_animations(const RunPlan& plan, RunObserver& observer);

}  // namespace etendue
