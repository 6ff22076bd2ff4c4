// Experiments on images: scenes x structures x methods x seeds, each cell's error and time measured as it converges.
#pragma once

#include "experiments/kind.h"

namespace etendue {

const ExperimentKind& images_kind();

}  // namespace etendue
