// Experiments on claims (claims_config.h).
#pragma once

#include "experiments/kind.h"

namespace etendue {

const ExperimentKind& claims_kind();

}  // namespace etendue
