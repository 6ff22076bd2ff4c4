// The table of traversals for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/bvh/wide/wide_batch.inl"

#if defined(__AVX2__)
#include "accel/bvh/wide/small_geometry.inl"
#endif

namespace etendue {
namespace {

// Takes the answers of a batch: hits, or whether there are any. It knows no tree, so that what asks none is compiled once for
// all.
template <class T>
struct Answers {
  static constexpr bool any_hit = std::is_same_v<T, bool>;
  std::span<T> of;

  void operator()(std::size_t i, const Hit& hit) const {
    if constexpr (any_hit)
      of[i] = static_cast<bool>(hit);
    else
      of[i] = placed(hit);
  }
};

#if defined(__AVX2__)
template <class T>
void trace_small(const SmallGeometry& small, const Geometry& geometry, std::span<const Ray> rays, const Answers<T>& answer) {
  for (std::size_t begin = 0; begin < rays.size(); begin += widest_lanes)
    SmallGeometryQuery<Answers<T>::any_hit>::run(small, geometry, rays.subspan(begin),
                                                 [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); });
}
#endif

template <class Simd, int node_width, class Pack, class T>
void trace_batch(const WideView<node_width, Pack>& view, std::span<const Ray> rays, std::span<T> answers) {
  const Answers<T> answer{answers};
#if defined(__AVX2__)
  if (!view.small.empty() && rays.size() >= widest_lanes / 2) return trace_small(view.small, view.geometry, rays, answer);
#endif
  trace_many<Simd, node_width, Pack, Answers<T>::any_hit>(view, rays, answer);
}

template <class Simd, int node_width, class Pack>
constexpr WideKernels<node_width, Pack> kernels() {
  using View = WideView<node_width, Pack>;
  return {
      [](const View& view, const Ray& ray) { return trace<Simd, false>(view, ray, CountNothing()); },
      [](const View& view, const Ray& ray) { return static_cast<bool>(trace<Simd, true>(view, ray, CountNothing())); },
      [](const View& view, std::span<const Ray> rays, std::span<Hit> hits) { trace_batch<Simd>(view, rays, hits); },
      [](const View& view, std::span<const Ray> rays, std::span<bool> occluded) { trace_batch<Simd>(view, rays, occluded); },
      [](const View& view, const Ray& ray, TraversalCounters& counters) {
        return trace<Simd, false>(view, ray, CountWork{counters});
      },
      [](const View& view, const Ray& ray, TraversalCounters& counters) {
        return static_cast<bool>(trace<Simd, true>(view, ray, CountWork{counters}));
      }};
}

template <class Simd>
const WideKernelSet& kernel_set() {
  static constexpr WideKernelSet set{kernels<Simd, 4, TrianglePack<4>>(), kernels<Simd, 8, TrianglePack<8>>(),
                                     kernels<Simd, 16, SharedPack>()};
  return set;
}

}  // namespace
}  // namespace etendue
