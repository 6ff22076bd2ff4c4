// Wide traversal without SIMD instructions: for other machines, and to test the others against.
#include "accel/ray/wide_headers.h"

#include "accel/ray/simd_lanes.inl"
#include "accel/ray/wide_kernels.inl"

namespace etendue {

const WideKernelSet& wide_kernels_scalar() { return kernel_set<Simd<1>>(); }

}  // namespace etendue
