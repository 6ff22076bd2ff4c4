// Experiments on point or record structures (search_config.h).
#pragma once

#include "experiments/kind.h"

namespace etendue {

const ExperimentKind& search_kind();

}  // namespace etendue
