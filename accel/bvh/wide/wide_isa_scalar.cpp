// Wide traversal without SIMD instructions: for other machines, and to test the others against.
#include "accel/bvh/wide/wide_headers.h"

#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_scalar() { return kernel_set<Simd<1>>(); }

}  // namespace etendue
