// Wide traversal with SSE4.1: four lanes.
#include "accel/bvh/wide/wide_headers.h"

#if defined(__x86_64__)

#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_sse() { return kernel_set<Simd<4>>(); }

}  // namespace etendue

#endif
