// The run of an experiment on claims: as execute_run, for cells that are (claim, measurement, scene).
#pragma once

#include "experiments/run/run.h"

namespace etendue {

RunSummary execute_claims(const RunPlan& plan, RunObserver& observer);

}  // namespace etendue
