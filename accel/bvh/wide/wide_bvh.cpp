#include "accel/bvh/wide/wide_bvh.h"

#include "accel/bvh/wide/wide_isa.h"
#include "framework/core/check.h"

#include <array>

namespace etendue {

namespace {

template <int node_width, class Pack>
const WideKernels<node_width, Pack>& kernels_of(const WideKernelSet& set) {
  if constexpr (node_width == 4) return set.bvh4;
  if constexpr (node_width == 8) return set.bvh8;
  if constexpr (node_width == 16) return set.bvh16;
}

}  // namespace

std::string_view isa_name(Isa isa) {
  static constexpr std::array<std::string_view, 4> names{"scalar", "SSE4.1", "AVX2", "AVX-512"};
  return names[static_cast<std::size_t>(isa)];
}

std::span<const Isa> supported_isas() {
  static const std::vector<Isa> supported = [] {
    std::vector<Isa> isas{Isa::scalar};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("sse4.1")) isas.push_back(Isa::sse);
    if (__builtin_cpu_supports("avx2")) isas.push_back(Isa::avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
      isas.push_back(Isa::avx512);
#endif
    return isas;
  }();
  return supported;
}

template <int node_width, class Pack>
const WideKernels<node_width, Pack>& wide_kernels(Isa isa) {
  switch (isa) {
    case Isa::scalar:
      return kernels_of<node_width, Pack>(wide_kernels_scalar());
#if defined(__x86_64__)
    case Isa::sse:
      return kernels_of<node_width, Pack>(wide_kernels_sse());
    case Isa::avx2:
      return kernels_of<node_width, Pack>(wide_kernels_avx2());
    case Isa::avx512:
      return kernels_of<node_width, Pack>(wide_kernels_avx512());
#else
    default:
      break;
#endif
  }
  CHECK(!"an instruction set of this machine");
  __builtin_unreachable();
}

template const WideKernels<4, TrianglePack<4>>& wide_kernels(Isa);
template const WideKernels<8, TrianglePack<8>>& wide_kernels(Isa);
template const WideKernels<16, SharedPack>& wide_kernels(Isa);

static_assert(RayStructure<Bvh4> && RayStructure<Bvh8> && RayStructure<Bvh16>);

}  // namespace etendue
