// The catalogue of failures (stress_config.h): each row's methods under all seeds, measured against the scene's reference.
#pragma once

#include "experiments/kind.h"

namespace etendue {

const ExperimentKind& stress_kind();

}  // namespace etendue
