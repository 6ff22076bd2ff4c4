// How a batch of rays goes through a wide tree, for one instruction set; included like wide_tests.inl.
//
// Rays that keep together go in packets. Where many of the others miss the scene's box, SIMD tells which, with a ray in each
// lane. Shadow rays that are left go in streams. Other rays go in streams where the instruction set is quick to tell them apart
// (Simd::streams_nearest), but for some that go one by one: those that start apart, as a stream takes children in an order that
// suits few of them, and those that meet few nodes, which leave a stream little to share. Whichever way a ray goes, its answer
// is the same.
#pragma once

#include "accel/bvh/wide/wide_packet.inl"
#include "accel/bvh/wide/wide_shadow_stream.inl"
#include "accel/bvh/wide/wide_stream.inl"
#include "accel/bvh/wide/wide_traversal.inl"

namespace etendue {
namespace {

inline constexpr int runs_apart = 3;           // of packet_size rays, which go in streams after a packet near them did not pay
inline constexpr std::uint64_t few_nodes = 2;  // that a ray visits, with which a stream does not pay
inline constexpr std::size_t judges = 16;      // rays that tell whether those after them visit few
inline constexpr int runs_inside = 8;          // of packet_size rays, after some of which most met the root's box

// The root's box.
template <int node_width>
Bounds box_of(const WideNode<node_width>& root) {
  Bounds box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = *std::min_element(root.planes[axis], root.planes[axis] + node_width);
    box.upper[axis] = *std::max_element(root.planes[3 + axis], root.planes[3 + axis] + node_width);
  }
  return box;
}

// Finds those of packet_size rays that may meet a box, a bit each. The others meet nothing in it: the test is that of
// box_test.h with a ray in each lane, but that an axis along which a reciprocal is infinite restricts nothing.
template <class Simd>
std::uint64_t rays_meeting(const Bounds& box, std::span<const Ray> rays) {
  using Rays = typename Simd::template Floats<16>;
  alignas(64) float origin[3][packet_size], direction[3][packet_size], t_min[packet_size];
  for (int i = 0; i < packet_size; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][i] = rays[i].origin[axis];
      direction[axis][i] = rays[i].direction[axis];
    }
    t_min[i] = rays[i].t_min;
  }
  std::uint64_t missing = 0;
  for (int i = 0; i < packet_size; i += 16) {
    Rays near = Rays::load(t_min + i), far = Rays::set(infinity);
    for (int axis = 0; axis < 3; ++axis) {
      const Rays from = Rays::load(origin[axis] + i), to_lower = Rays::set(box.lower[axis]) - from,
                 to_upper = Rays::set(box.upper[axis]) - from;
      Rays reciprocal = Rays::set(1) / Rays::load(direction[axis] + i);
      reciprocal = reciprocal + (reciprocal - reciprocal);  // NaN where infinite
      const Rays padded = reciprocal * Rays::set(slab_pad);
      near = larger(smaller(to_lower * reciprocal, to_upper * reciprocal), near);
      far = smaller(larger(to_lower * padded, to_upper * padded), far);
    }
    missing |= std::uint64_t{less(far, near)} << i;
  }
  return ~missing;
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
  TraversalCounters counters;
  std::uint64_t traced = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint64_t before = counters.nodes;
    answer(i, trace<Simd, false>(view, rays[i], CountWork{counters}));
    traced += counters.nodes > before;
  }
  return counters.nodes < few_nodes * traced;
}

// `answer(i, hit)` is called once for every ray.
template <class Simd, int node_width, class Pack, bool any_hit, class Answer>
void trace_many(const WideView<node_width, Pack>& view, std::span<const Ray> rays, const Answer& answer) {
  if (view.tree.nodes.empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i) answer(i, Hit{});
    return;
  }
  const Bounds box = box_of(view.tree.nodes[0]);
  const float size = max_component(box.upper - box.lower);
  constexpr bool streams = any_hit || Simd::streams_nearest;
  using Nearest = std::conditional_t<streams, WideStream<Simd, node_width, Pack>, NoStream>;
  using Stream = std::conditional_t<any_hit, WideShadowStream<Simd, node_width, Pack>, Nearest>;
  Stream stream(view, rays);
  bool are_short = false;  // rays that go in no packet, as judged last
  std::size_t judged = 0;  // where to judge them next
  int unpacked = 0;        // of runs_apart, still to come
  int inside = 0;          // of runs_inside, still to come
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
      std::uint64_t meeting = ~std::uint64_t{0};
      if (inside > 0) {
        --inside;
      } else if (some.size() == packet_size) {
        meeting = rays_meeting<Simd>(box, some);
        if (std::popcount(meeting) > 3 * packet_size / 4) inside = runs_inside;
      }
      std::size_t first = 0;
      if constexpr (any_hit) {
        stream.make_room();
      } else if constexpr (streams) {
        if (begin >= judged) {
          first = std::min(judges, some.size());
          are_short = visit_few<Simd>(view, some.first(first), [&](std::size_t i, const Hit& hit) { answer(begin + i, hit); });
          judged = begin + Stream::most;
        }
      }
      const bool singly = !streams || (!any_hit && (are_short || start_apart(some, size)));
      for (std::size_t i = first; i < some.size(); ++i) {
        if ((meeting >> i & 1) == 0)
          answer(begin + i, Hit{});
        else if (singly)
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
