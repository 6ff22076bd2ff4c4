// Runs the catalogue of failures: each row's methods under all seeds, measured against the scene's truth.
#pragma once

#include "experiments/run/run.h"

namespace etendue {

RunSummary execute_stress(const RunPlan& plan, RunObserver& observer);

}  // namespace etendue
