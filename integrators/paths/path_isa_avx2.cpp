// Paths in the lanes of AVX2.
#if defined(__x86_64__)
#include "integrators/paths/path_wide.inl"

namespace etendue {

const PathKernels& path_kernels_avx2() {
  static constexpr PathKernels kernels = kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

}  // namespace etendue
#endif
