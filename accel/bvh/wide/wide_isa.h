// Each wide_isa_*.cpp provides what is declared here.
#pragma once

#include "accel/bvh/build/binned_kernels.h"
#include "accel/bvh/wide/wide_bvh.h"

namespace etendue {

struct WideKernelSet {
  WideKernels<4, TrianglePack<4>> bvh4;
  WideKernels<8, TrianglePack<8>> bvh8;
  WideKernels<16, SharedPack> bvh16;
};

const WideKernelSet& wide_kernels_four();
const WideKernelSet& wide_kernels_avx2();
const WideKernelSet& wide_kernels_avx512();

const BinnedKernels& binned_kernels_four();
const BinnedKernels& binned_kernels_avx2();

}  // namespace etendue
