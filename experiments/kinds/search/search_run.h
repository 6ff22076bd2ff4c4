// The run of an experiment that compares point or ball structures: as execute_run, for cells that are sets.
#pragma once

#include "experiments/run/run.h"

namespace etendue {

RunSummary execute_search(const RunPlan& plan, RunObserver& observer);

}  // namespace etendue
