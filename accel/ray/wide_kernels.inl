// The table of traversals for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/ray/wide_packet.inl"
#include "accel/ray/wide_stream.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {
namespace {

// The larger side of the root's box.
template <int node_width>
float size_of(const WideNode<node_width>& root) {
  vec3 size;
  for (int axis = 0; axis < 3; ++axis) {
    const float *const lower = root.planes[2 * axis], *const upper = root.planes[2 * axis + 1];
    size[axis] = *std::max_element(upper, upper + node_width) - *std::min_element(lower, lower + node_width);
  }
  return max_component(size);
}

// Rays that keep together go in packets, the others in streams.
template <class Simd, int node_width, class Pack, bool any_hit, class Answer>
void trace_many(const WideView<node_width, Pack>& view, std::span<const Ray> rays, const Answer& answer) {
  if (view.tree.nodes.empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i) answer(i, Hit{});
    return;
  }
  const float size = size_of(view.tree.nodes[0]);
  WideStream<Simd, node_width, Pack, any_hit> stream(view);
  int unpacked = 0;  // runs of packet_size rays still to go in streams, as one in their neighbourhood did not pay as a packet
  for (std::size_t begin = 0; begin < rays.size(); begin += packet_size) {
    const std::span<const Ray> some = rays.subspan(begin, std::min<std::size_t>(packet_size, rays.size() - begin));
    const bool packed = unpacked == 0 && some.size() == packet_size;
    const PacketBounds bounds = packed ? packet_bounds<Simd>(some, size) : PacketBounds();
    const auto answer_some = [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); };
    if (unpacked > 0) {
      --unpacked;
    } else if (bounds.coherent) {
      if (WidePacket<Simd, node_width, Pack, any_hit>::run(view, bounds, some, answer_some)) continue;
      unpacked = 3;
    }
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (is_traceable(some[i]))
        stream.add(some[i], begin + i);
      else
        answer(begin + i, Hit{});
    }
    if (stream.size() + packet_size > stream_size) stream.run(answer);
  }
  stream.run(answer);
}

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
