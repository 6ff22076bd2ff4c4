#include "accel/bvh/wide/wide_bvh.h"

#include "accel/bvh/wide/wide_isa.h"
#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

namespace {

const WideKernelSet& kernels_of(Isa isa) {
  switch (isa) {
    case Isa::scalar:
    case Isa::sse:
      return wide_kernels_four();
#if defined(__x86_64__)
    case Isa::avx2:
      return wide_kernels_avx2();
    case Isa::avx512:
      return wide_kernels_avx512();
#else
    default:
      break;
#endif
  }
  CHECK(!"an instruction set of this machine");
  __builtin_unreachable();
}

}  // namespace

template <int node_width, class Pack>
const WideKernels<node_width, Pack>& wide_kernels(Isa isa) {
  const WideKernelSet& set = kernels_of(isa);
  if constexpr (node_width == 4) return set.bvh4;
  if constexpr (node_width == 8) return set.bvh8;
  if constexpr (node_width == 16) return set.bvh16;
}

// A box is eight floats. Compilers for AVX-512 turn its minima into comparisons and choices, which takes a tenth longer.
const BinnedKernels& binned_kernels(Isa isa) { return kernels_of(std::min(isa, Isa::avx2)).binned; }

template const WideKernels<4, TrianglePack<4>>& wide_kernels(Isa);
template const WideKernels<8, TrianglePack<8>>& wide_kernels(Isa);
template const WideKernels<16, SharedPack>& wide_kernels(Isa);

static_assert(RayStructure<Bvh4> && RayStructure<Bvh8> && RayStructure<Bvh16>);

}  // namespace etendue
