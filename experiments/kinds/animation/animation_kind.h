// Experiments on change over time (animation.h).
#pragma once

#include "experiments/kind.h"

namespace etendue {

const ExperimentKind& animation_kind();

}  // namespace etendue
