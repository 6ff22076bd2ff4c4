// The run of an experiment on images: scenes, structures and methods, each cell measured at its checkpoints.
#pragma once

#include "experiments/run/run.h"

namespace etendue {

RunSummary execute_images(const RunPlan& plan, RunObserver& observer, const CellFunction& compute);

}  // namespace etendue
