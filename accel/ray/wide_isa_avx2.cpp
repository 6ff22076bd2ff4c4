// Wide traversal with AVX2: eight lanes.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_lanes.inl"
#include "accel/ray/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_avx2() { return kernel_set<Simd<8>>(); }

}  // namespace etendue

#endif
