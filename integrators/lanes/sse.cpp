// Transport in the lanes of SSE4.1.
#if defined(__x86_64__)
#include "integrators/lanes/path_wide.inl"
#include "integrators/lanes/photon_wide.inl"

namespace etendue {

const PathKernels& path_kernels_sse() {
  static constexpr PathKernels kernels = path_kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}
const PhotonKernels& photon_kernels_sse() {
  static constexpr PhotonKernels kernels = photon_kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

}  // namespace etendue
#endif
