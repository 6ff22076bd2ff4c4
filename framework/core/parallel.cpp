#include "framework/core/parallel.h"

#include <tbb/info.h>

namespace etendue {

int hardware_threads() { return tbb::info::default_concurrency(); }

}  // namespace etendue
