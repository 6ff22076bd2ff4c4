// Wide traversal with four lanes: SSE4.1, or what the compiler makes of its vectors on other machines.
#include "accel/bvh/wide/wide_headers.h"

#include "accel/bvh/build/binned_kernels.inl"
#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_four() { return kernel_set<Simd<4>>(); }
const BinnedKernels& binned_kernels_four() { return binned_kernels_here; }

}  // namespace etendue
