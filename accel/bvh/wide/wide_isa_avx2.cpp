// Wide traversal with AVX2: eight lanes.
#include "accel/bvh/wide/wide_headers.h"

#if defined(__x86_64__)

#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_avx2() { return kernel_set<Simd<8>>(); }

}  // namespace etendue

#endif
