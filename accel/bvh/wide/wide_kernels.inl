// The table of traversals for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/bvh/wide/wide_batch.inl"

namespace etendue {
namespace {

template <class Simd, int node_width, class Pack>
constexpr WideKernels<node_width, Pack> kernels() {
  using View = WideView<node_width, Pack>;
  return {[](const View& view, const Ray& ray) { return trace<Simd, false>(view, ray, CountNothing()); },
          [](const View& view, const Ray& ray) { return static_cast<bool>(trace<Simd, true>(view, ray, CountNothing())); },
          [](const View& view, std::span<const Ray> rays, std::span<Hit> hits) {
            trace_many<Simd, node_width, Pack, false>(view, rays,
                                                      [&](std::size_t i, const Hit& hit) { hits[i] = placed(hit); });
          },
          [](const View& view, std::span<const Ray> rays, std::span<bool> occluded) {
            trace_many<Simd, node_width, Pack, true>(
                view, rays, [&](std::size_t i, const Hit& hit) { occluded[i] = static_cast<bool>(hit); });
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
