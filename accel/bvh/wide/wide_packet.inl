// Coherent rays through a wide tree together, as a camera sends them through neighbouring pixels, for one instruction set;
// included like wide_tests.inl.
//
// A node is visited once for a whole packet: interval arithmetic over its rays' origins and reciprocal directions bounds where
// any of them can enter and leave each child ([Wald2007a]), a child in each lane. At a leaf the rays themselves are told apart
// by its box, a ray in each lane, and those that meet it are tested. Bounds round as the rays' own tests do, and rounding is
// monotone: no child is lost that a ray by itself would visit. Answers are those of single rays, to the bit. A packet that is
// wide for its leaves, so that few of its rays meet each, is given up.
#pragma once

#include "accel/bvh/wide/wide_tests.inl"

namespace etendue {
namespace {

// Rays of a packet: enough to share the cost of a visit, few enough to look the same way.
inline constexpr int packet_size = 64;

// Holds what a packet's rays have in common. `coherent` is false where rays are too many, few or different for a packet to pay.
struct PacketBounds {
  vec3 origin_lower, origin_upper;
  vec3 direction_lower, direction_upper;
  float t_min;  // the least
  bool coherent = false;
};

template <class Simd>
PacketBounds packet_bounds(std::span<const Ray> rays, float scene_size) {
  using Four = typename Simd::template Floats<4>;
  // A packet pays up to these spreads: of directions relative to their length, of origins relative to the scene's size.
  constexpr float direction_spread = 0.125f, origin_spread = 0.03125f;
  static_assert(sizeof(Ray) == 8 * sizeof(float));
  PacketBounds bounds;
  if (rays.size() != packet_size) return bounds;
  // Most packets that are not coherent show it in a few rays.
  const auto octant = [](const Ray& ray) {
    return std::signbit(ray.direction.x) | std::signbit(ray.direction.y) << 1 | std::signbit(ray.direction.z) << 2;
  };
  for (int i = 7; i < packet_size; i += 8)
    if (octant(rays[i]) != octant(rays[0])) return bounds;
  Four lower[2], upper[2], finite = Four::set(0);
  for (int half = 0; half < 2; ++half) lower[half] = upper[half] = Four::load_anywhere(&rays.front().origin.x + 4 * half);
  unsigned ordered = 8;
  for (const Ray& ray : rays) {
    const Four origin = Four::load_anywhere(&ray.origin.x), direction = Four::load_anywhere(&ray.direction.x);
    lower[0] = smaller(origin, lower[0]);
    upper[0] = larger(origin, upper[0]);
    lower[1] = smaller(direction, lower[1]);
    upper[1] = larger(direction, upper[1]);
    finite = finite + (origin - origin) + (direction - direction);
    ordered &= less_equal(origin, direction);  // t_min and t_max
  }
  alignas(16) float values[4][4];
  for (int half = 0; half < 2; ++half) {
    lower[half].store(values[half]);
    upper[half].store(values[2 + half]);
  }
  bounds.origin_lower = vec3(values[0][0], values[0][1], values[0][2]);
  bounds.direction_lower = vec3(values[1][0], values[1][1], values[1][2]);
  bounds.origin_upper = vec3(values[2][0], values[2][1], values[2][2]);
  bounds.direction_upper = vec3(values[3][0], values[3][1], values[3][2]);
  bounds.t_min = values[0][3];
  if (ordered == 0 || (equal(finite, finite) & 7) != 7) return bounds;
  float longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = bounds.direction_lower[axis], b = bounds.direction_upper[axis];
    if (!(a > 0 || b < 0) || std::isinf(1 / a) || std::isinf(1 / b)) return bounds;
    longest = std::max({longest, a, -b});
  }
  bounds.coherent = max_component(bounds.direction_upper - bounds.direction_lower) <= direction_spread * longest &&
                    max_component(bounds.origin_upper - bounds.origin_lower) <= origin_spread * scene_size;
  return bounds;
}

// The slab test of all rays of a packet at once, with a child in each lane.
template <class Simd, int node_width>
class PacketNodeTest {
 public:
  using Boxes = typename Simd::template Floats<node_width>;

  explicit PacketNodeTest(const PacketBounds& rays) : t_min_(Boxes::set(rays.t_min)) {
    std::uint32_t signs = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = rays.direction_upper[axis] < 0;
      signs |= static_cast<std::uint32_t>(negative) << axis;
      near_origin_[axis] = Boxes::set(negative ? rays.origin_lower[axis] : rays.origin_upper[axis]);
      far_origin_[axis] = Boxes::set(negative ? rays.origin_upper[axis] : rays.origin_lower[axis]);
      reciprocal_[axis][0] = Boxes::set(1 / rays.direction_lower[axis]);
      reciprocal_[axis][1] = Boxes::set(1 / rays.direction_upper[axis]);
      padded_reciprocal_[axis][0] = Boxes::set(1 / rays.direction_lower[axis] * slab_pad);
      padded_reciprocal_[axis][1] = Boxes::set(1 / rays.direction_upper[axis] * slab_pad);
    }
    places = &plane_places<node_width>[signs];
  }

  // The children that some ray may meet, a bit each; `near`: no ray enters them before. `far`: the largest of the rays'.
  [[gnu::always_inline]] unsigned met(const WideNode<node_width>& node, Boxes far, Boxes& near) const {
    const float* const planes = node.planes[0];
    near = t_min_;
    for (int axis = 0; axis < 3; ++axis) {
      const Boxes to_near = Boxes::load(planes + places->near[axis]) - near_origin_[axis];
      const Boxes to_far = Boxes::load(planes + places->far[axis]) - far_origin_[axis];
      near = larger(smaller(to_near * reciprocal_[axis][0], to_near * reciprocal_[axis][1]), near);
      far = smaller(larger(to_far * padded_reciprocal_[axis][0], to_far * padded_reciprocal_[axis][1]), far);
    }
    return less_equal(near, far);
  }

  const PlanePlaces* places;

 private:
  const Boxes t_min_;
  Boxes near_origin_[3], far_origin_[3], reciprocal_[3][2], padded_reciprocal_[3][2];
};

// TriangleRay of each ray of a packet, worked out in lanes by the rules of its constructor.
class PacketShears {
 public:
  // By axis and ray.
  void set(const float (&direction)[3][packet_size]) {
    for (int i = 0; i < packet_size; ++i) {
      const float x = direction[0][i], y = direction[1][i], z = direction[2][i];
      const float size_x = std::abs(x), size_y = std::abs(y), size_z = std::abs(z);
      const bool is_z = !((size_x > size_y ? size_x : size_y) > size_z), is_y = !is_z && !(size_x > size_y);
      const float along = is_z ? z : is_y ? y : x;
      const float next = is_z ? x : is_y ? z : y, after = is_z ? y : is_y ? x : z;
      const std::int32_t k = is_z ? 2 : is_y ? 1 : 0, k_next = is_z ? 0 : is_y ? 2 : 1, k_after = is_z ? 1 : is_y ? 0 : 2;
      const bool backwards = along < 0;
      kx_[i] = backwards ? k_after : k_next;
      ky_[i] = backwards ? k_next : k_after;
      kz_[i] = k;
      sx_[i] = (backwards ? after : next) / along;
      sy_[i] = (backwards ? next : after) / along;
      sz_[i] = 1.0f / along;
    }
  }
  TriangleRay operator[](int i) const {
    TriangleRay ray;
    ray.kx = kx_[i];
    ray.ky = ky_[i];
    ray.kz = kz_[i];
    ray.sx = sx_[i];
    ray.sy = sy_[i];
    ray.sz = sz_[i];
    return ray;
  }

 private:
  alignas(64) std::int32_t kx_[packet_size], ky_[packet_size], kz_[packet_size];
  alignas(64) float sx_[packet_size], sy_[packet_size], sz_[packet_size];
};

template <class Simd, int node_width, class Pack, bool any_hit>
class WidePacket {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;
  using Rays = typename Simd::template Floats<16>;
  static constexpr int vectors = packet_size / 16;
  static constexpr std::uint32_t trial = 12;  // leaves after which a packet must pay

 public:
  // packet_size rays with coherent bounds. `answer(i, hit)` is called once for every ray, or for none and the answer is false:
  // then the rays are better traced otherwise.
  template <class Answer>
  [[gnu::flatten]] static bool run(const View& view, const PacketBounds& bounds, std::span<const Ray> rays,
                                   const Answer& answer) {
    const PacketNodeTest<Simd, node_width> node_test(bounds);
    WidePacket packet(view, node_test, rays);
    if (!packet.traverse()) return false;
    for (std::size_t i = 0; i < rays.size(); ++i) answer(i, packet.hits_[i]);
    return true;
  }

 private:
  struct Place {
    std::uint32_t node, slot;
    float entry;  // no ray enters before
  };

  WidePacket(const View& view, const PacketNodeTest<Simd, node_width>& node_test, std::span<const Ray> rays)
      : view_(view), node_test_(node_test), rays_(rays) {
    alignas(64) float direction[3][packet_size];
    for (int i = 0; i < packet_size; ++i) {
      const Ray& ray = rays[i];
      for (int axis = 0; axis < 3; ++axis) {
        origin_[axis][i] = ray.origin[axis];
        direction[axis][i] = ray.direction[axis];
      }
      t_min_[i] = ray.t_min;
      hits_[i].t = farthest_hit(ray);
    }
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < packet_size; ++i) {
        reciprocal_[axis][i] = 1 / direction[axis][i];
        padded_reciprocal_[axis][i] = reciprocal_[axis][i] * slab_pad;
      }
    shears_.set(direction);
    for (int i = 0; i < packet_size; ++i) far_[i] = TraversalLimit(rays[i], view.extent)(hits_[i].t);
    find_farthest();
  }

  void find_farthest() {
    Rays most = Rays::load(far_);
    for (int v = 1; v < vectors; ++v) most = larger(Rays::load(far_ + 16 * v), most);
    alignas(64) float values[16];
    most.store(values);
    for (int half = 8; half > 0; half /= 2)
      for (int i = 0; i < half; ++i) values[i] = std::max(values[i], values[i + half]);
    farthest_ = values[0];
  }

  [[gnu::always_inline]] bool traverse() {
    const auto& tree = view_.tree;
    TraversalStack<Place, 256> stack(tree.depth * (node_width - 1) + node_width);
    Place* const bottom = stack.begin();
    Place* top = visit(0, bottom);
    while (top != bottom) {
      const Place place = *--top;
      if (place.entry > farthest_) continue;
      const WideNode<node_width>& parent = tree.nodes[place.node];
      const WideRef child = parent.children[place.slot];
      if (child.is_leaf())
        test_leaf(parent, static_cast<int>(place.slot), child);
      else
        top = visit(child.index(), top);
      if (leaves_ >= trial && 2 * tests_ < 3 * leaves_) return false;
    }
    return true;
  }

  // Stacks the children that the packet may meet, the one it enters first on top.
  [[gnu::always_inline]] Place* visit(std::uint32_t index, Place* top) {
    const WideNode<node_width>& node = view_.tree.nodes[index];
    Boxes near;
    unsigned met = node_test_.met(node, Boxes::set(farthest_), near);
    if (met == 0) return top;
    alignas(64) float entries[node_width];
    near.store(entries);
    Place* const first = top;
    for (; met != 0; met &= met - 1) {
      const auto slot = static_cast<std::uint32_t>(std::countr_zero(met));
      prefetch(view_.tree, node.children[slot]);
      Place* to = top++;
      for (; to != first && to[-1].entry < entries[slot]; --to) *to = to[-1];
      *to = {index, slot, entries[slot]};
    }
    return top;
  }

  // The rays of a vector that meet a child.
  [[gnu::always_inline]] unsigned rays_meeting(const float* child_planes, int vector) const {
    using Test = BoxTest<Rays, node_width>;
    const auto axis = [&](int a) {
      return typename Test::Axis{Rays::load(origin_[a] + 16 * vector), Rays::load(reciprocal_[a] + 16 * vector),
                                 Rays::load(padded_reciprocal_[a] + 16 * vector)};
    };
    Rays near;
    return Test(*node_test_.places, Rays::load(t_min_ + 16 * vector), axis(0), axis(1), axis(2))
        .met([&](std::uint32_t place) { return Rays::set(child_planes[place]); }, Rays::load(far_ + 16 * vector), near);
  }

  [[gnu::always_inline]] void test_leaf(const WideNode<node_width>& parent, int slot, WideRef leaf) {
    bool found = false;
    ++leaves_;
    for (int v = 0; v < vectors; ++v)
      for (unsigned met = rays_meeting(parent.planes[0] + slot, v); met != 0; met &= met - 1)
        found |= test_ray(16 * v + std::countr_zero(met), leaf);
    if (found) find_farthest();
  }

  [[gnu::always_inline]] bool test_ray(int i, WideRef leaf) {
    const Ray& ray = rays_[i];
    ++tests_;
    const TriangleRay shear = shears_[i];
    CountNothing nothing;
    const LeafQuery<Simd, Pack, any_hit, CountNothing> test(shear, origin_[shear.kx][i], origin_[shear.ky][i],
                                                            origin_[shear.kz][i]);
    if (!test.test(view_, ray, leaf, hits_[i], nothing)) return false;
    far_[i] = any_hit ? -infinity : TraversalLimit(ray, view_.extent)(hits_[i].t);
    return true;
  }

  const View& view_;
  const PacketNodeTest<Simd, node_width>& node_test_;
  const std::span<const Ray> rays_;
  // By ray: what its slab test takes, how far it must look, and its best hit so far.
  alignas(64) float origin_[3][packet_size], reciprocal_[3][packet_size], padded_reciprocal_[3][packet_size];
  alignas(64) float t_min_[packet_size], far_[packet_size];
  float farthest_;
  Hit hits_[packet_size];
  PacketShears shears_;
  std::uint32_t leaves_ = 0, tests_ = 0;  // visits, and what rays came of them
};

}  // namespace
}  // namespace etendue
