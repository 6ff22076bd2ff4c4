// What each wide_isa_*.cpp provides.
#pragma once

#include "accel/bvh/wide/wide_bvh.h"

namespace etendue {

struct WideKernelSet {
  WideKernels<4, TrianglePack<4>> wide4;
  WideKernels<8, TrianglePack<8>> wide8;
  WideKernels<16, SharedPack> wide16;
};

const WideKernelSet& wide_kernels_scalar();
const WideKernelSet& wide_kernels_sse();
const WideKernelSet& wide_kernels_avx2();
const WideKernelSet& wide_kernels_avx512();

}  // namespace etendue
