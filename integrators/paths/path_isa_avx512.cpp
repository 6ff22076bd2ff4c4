// Paths in the lanes of AVX-512.
#if defined(__x86_64__)
#include "integrators/paths/path_wide.inl"

namespace etendue {

const PathKernels& path_kernels_avx512() {
  static constexpr PathKernels kernels = kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

}  // namespace etendue
#endif
