// How a batch of rays goes through a wide tree, for one instruction set; included like wide_tests.inl.
//
// Rays that keep together go in packets, other shadow rays in streams. The rest go in streams where the instruction set is
// quick to tell them apart (Simd::streams_nearest), but for some that go one by one: those that start apart, as a stream takes
// children in an order that suits few of them, and those that meet few nodes, which leave a stream little to share. Whichever
// way a ray goes, its answer is the same.
#pragma once

#include "accel/bvh/wide/wide_packet.inl"
#include "accel/bvh/wide/wide_shadow_stream.inl"
#include "accel/bvh/wide/wide_stream.inl"
#include "accel/bvh/wide/wide_traversal.inl"

namespace etendue {
namespace {

inline constexpr int runs_apart = 3;           // of packet_size rays, which go in streams after a packet near them did not pay
inline constexpr std::uint32_t few_nodes = 2;  // that a ray visits, with which a stream does not pay
inline constexpr std::size_t judges = 16;      // rays that tell whether those after them visit few

// The largest side of the root's box.
template <int node_width>
float size_of(const WideNode<node_width>& root) {
  vec3 size;
  for (int axis = 0; axis < 3; ++axis) {
    const float *const lower = root.planes[axis], *const upper = root.planes[3 + axis];
    size[axis] = *std::max_element(upper, upper + node_width) - *std::min_element(lower, lower + node_width);
  }
  return max_component(size);
}

// Do rays start all over a scene of this size? Judged by a few of them.
inline bool start_apart(std::span<const Ray> rays, float size) {
  vec3 lower(infinity), upper(-infinity);
  for (std::size_t i = 0; i < rays.size(); i += 8) {
    lower = glm::min(lower, rays[i].origin);
    upper = glm::max(upper, rays[i].origin);
  }
  return max_component(upper - lower) > 0.9f * size;
}

// Takes no ray in.
struct NoStream {
  static constexpr std::size_t most = packet_size;

  template <class View>
  NoStream(const View&, std::span<const Ray>) {}
  bool add(std::size_t) { return false; }
  std::size_t size() const { return 0; }
  template <class Answer>
  void run(const Answer&) {}
};

// Answers rays one by one; says whether those that may be traced visited few nodes.
template <class Simd, int node_width, class Pack, class Answer>
bool visit_few(const WideView<node_width, Pack>& view, std::span<const Ray> rays, const Answer& answer) {
  std::uint32_t nodes = 0, traced = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint32_t before = nodes;
    answer(i, trace<Simd, false>(view, rays[i], CountNodes(nodes)));
    traced += nodes > before;
  }
  return nodes < few_nodes * traced;
}

// `answer(i, hit)` is called once for every ray.
template <class Simd, int node_width, class Pack, bool any_hit, class Answer>
void trace_many(const WideView<node_width, Pack>& view, std::span<const Ray> rays, const Answer& answer) {
  if (view.tree.nodes.empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i) answer(i, Hit{});
    return;
  }
  const float size = size_of(view.tree.nodes[0]);
  constexpr bool streams = any_hit || Simd::streams_nearest;
  using Nearest = std::conditional_t<streams, WideStream<Simd, node_width, Pack>, NoStream>;
  using Stream = std::conditional_t<any_hit, WideShadowStream<Simd, node_width, Pack>, Nearest>;
  Stream stream(view, rays);
  bool are_short = false;  // rays that go in no packet, as judged last
  std::size_t judged = 0;  // where to judge them next
  int unpacked = 0;        // of runs_apart, still to come
  for (std::size_t begin = 0; begin < rays.size();) {
    for (; begin < rays.size() && stream.size() + packet_size <= Stream::most; begin += packet_size) {
      const std::span<const Ray> some = rays.subspan(begin, std::min<std::size_t>(packet_size, rays.size() - begin));
      if (unpacked > 0) {
        --unpacked;
      } else if (const PacketBounds bounds = packet_bounds<Simd>(some, size); bounds.coherent) {
        if (WidePacket<Simd, node_width, Pack, any_hit>::run(view, bounds, some,
                                                             [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); }))
          continue;
        unpacked = runs_apart;
      }
      std::size_t first = 0;
      if constexpr (any_hit) {
        stream.make_room();
      } else if (streams && begin >= judged) {
        first = std::min(judges, some.size());
        are_short = visit_few<Simd>(view, some.first(first), [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); });
        judged = begin + Stream::most;
      }
      const bool singly = !streams || (!any_hit && (are_short || start_apart(some, size)));
      for (std::size_t i = first; i < some.size(); ++i) {
        if (singly)
          answer(begin + i, trace<Simd, false>(view, some[i], CountNothing()));
        else if (!stream.add(begin + i))
          answer(begin + i, Hit{});
      }
    }
    stream.run(answer);
  }
}

}  // namespace
}  // namespace etendue
