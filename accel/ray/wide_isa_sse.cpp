// Wide traversal with SSE4.1: four lanes.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_lanes.inl"
#include "accel/ray/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_sse() { return kernel_set<Simd<4>>(); }

}  // namespace etendue

#endif
