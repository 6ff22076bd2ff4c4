// The table of traversals for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/bvh/wide/wide_batch.inl"

#if defined(__AVX2__)
#include "accel/bvh/wide/small_geometry.inl"
#endif

namespace etendue {
namespace {

// `answer(i, hit)` is called once for every ray.
template <class Simd, bool any_hit, int node_width, class Pack, class Answer>
void trace_batch(const WideView<node_width, Pack>& view, std::span<const Ray> rays, const Answer& answer) {
#if defined(__AVX2__)
  if (!view.small.empty() && rays.size() >= widest_lanes / 2) {
    for (std::size_t begin = 0; begin < rays.size(); begin += widest_lanes)
      SmallGeometryQuery<any_hit>::run(view.small, view.geometry, rays.subspan(begin),
                                       [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); });
    return;
  }
#endif
  trace_many<Simd, node_width, Pack, any_hit>(view, rays, answer);
}

template <class Simd, int node_width, class Pack>
constexpr WideKernels<node_width, Pack> kernels() {
  using View = WideView<node_width, Pack>;
  return {[](const View& view, const Ray& ray) { return trace<Simd, false>(view, ray, CountNothing()); },
          [](const View& view, const Ray& ray) { return static_cast<bool>(trace<Simd, true>(view, ray, CountNothing())); },
          [](const View& view, std::span<const Ray> rays, std::span<Hit> hits) {
            trace_batch<Simd, false>(view, rays, [&](std::size_t i, const Hit& hit) { hits[i] = placed(hit); });
          },
          [](const View& view, std::span<const Ray> rays, std::span<bool> occluded) {
            trace_batch<Simd, true>(view, rays, [&](std::size_t i, const Hit& hit) { occluded[i] = static_cast<bool>(hit); });
          },
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
