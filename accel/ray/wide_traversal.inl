// The traversal of wide trees, for one instruction set: included once by each wide_isa_*.cpp, which the build compiles for its
// set. All is in an unnamed namespace, so that no code of one set can stand in for another's when the program is linked.
//
// `Simd::Floats<width>` is a vector of floats: load, set, store, + - * /, `larger` and `smaller` (which answer their second
// operand when one is NaN, as x86 does), and comparisons that give a bit per lane. Each operation rounds by itself (the project
// is compiled without FMA contraction), so all instruction sets give the same bits, and those of the scalar tests.

namespace etendue {
namespace {

// What waits on the stack: a place, and for closest hits where the ray enters it.
struct Waiting {
  WideRef place;
  float entry;
};

template <class Simd, int node_width, class Pack, bool any_hit, class Count>
class WideTraversal {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;
  using Lanes = typename Simd::template Floats<Pack::lanes>;
  using Waiting = std::conditional_t<any_hit, WideRef, etendue::Waiting>;

 public:
  WideTraversal(const View& view, const Ray& ray, Count count)
      : view_(view), ray_(ray), count_(count), limit_(ray, view.extent) {
    for (int axis = 0; axis < 3; ++axis) {
      origin_[axis] = Boxes::set(ray.origin[axis]);
      reciprocal_[axis] = Boxes::set(1.0f / ray.direction[axis]);
      near_plane_[axis] = 2 * axis + (std::signbit(ray.direction[axis]) ? 1 : 0);
    }
    hit_.t = std::min(ray.t_max, std::numeric_limits<float>::max());  // t is infinite where 1 / det is: no hit
  }

  Hit run() {
    const auto& tree = view_.tree;
    if (tree.nodes.empty()) return {};
    TraversalStack<Waiting, 256> stack(tree.depth * (node_width - 1) + node_width);
    Waiting* const bottom = stack.begin();
    Waiting* top = bottom;
    const Boxes t_min = Boxes::set(ray_.t_min);
    Boxes t_max = Boxes::set(limit_(hit_.t));
    WideRef place(WideRef::Kind::node, 0);
    bool prepared = false;
    for (;;) {
      if (!place.is_leaf()) {
        if (visit(tree.nodes[place.index()], t_min, t_max, place, top)) continue;
      } else if (prepared || (prepare_for_leaves(), prepared = true); test_leaf(place)) {
        if constexpr (any_hit) return hit_;
        t_max = Boxes::set(limit_(hit_.t));
      }
      if constexpr (any_hit) {
        if (top == bottom) return hit_;
        place = *--top;
      } else {
        const float limit = limit_(hit_.t);
        do {
          if (top == bottom) return hit_;
          --top;
        } while (top->entry > limit);
        place = top->place;
      }
    }
  }

 private:
  // What only leaves need of a ray: many rays see none.
  void prepare_for_leaves() {
    shear_ = TriangleRay(ray_.direction);
    sheared_origin_[0] = Lanes::set(ray_.origin[shear_.kx]);
    sheared_origin_[1] = Lanes::set(ray_.origin[shear_.ky]);
    sheared_origin_[2] = Lanes::set(ray_.origin[shear_.kz]);
    shear_x_ = Lanes::set(shear_.sx);
    shear_y_ = Lanes::set(shear_.sy);
    shear_z_ = Lanes::set(shear_.sz);
  }

  // Tests the children of a node, stacks all that are met but the one to go on to, and says whether there is one.
  [[gnu::always_inline]] bool visit(const WideNode<node_width>& node, const Boxes& t_min, const Boxes& t_max, WideRef& next,
                                    Waiting*& top) {
    count_.node();
    Boxes near = t_min, far = Boxes::set(infinity);
    for (int axis = 0; axis < 3; ++axis) {
      const int plane = near_plane_[axis];
      near = larger((Boxes::load(node.planes[plane]) - origin_[axis]) * reciprocal_[axis], near);
      far = smaller((Boxes::load(node.planes[plane ^ 1]) - origin_[axis]) * reciprocal_[axis], far);
    }
    const unsigned met = less_equal(near, smaller(far * Boxes::set(slab_pad), t_max));
    if (met == 0) return false;
    int first = std::bit_width(met) - 1;
    if (const unsigned others = met & ~(1u << first); others != 0) {
      if constexpr (any_hit) {
        top = Simd::stack_places(node, others, top);
      } else {
        first = Simd::template nearest<node_width>(near, met);
        top = Simd::stack_places(node, near, met & ~(1u << first), top);
      }
    }
    next = node.children[first];
    prefetch(next);
    return true;
  }

  // The lines of the next node or pack, all at once: each would otherwise be waited for in turn.
  [[gnu::always_inline]] void prefetch(WideRef place) const {
    const char* begin;
    std::size_t size;
    if (!place.is_leaf()) {
      begin = reinterpret_cast<const char*>(&view_.tree.nodes[place.index()]);
      size = sizeof(view_.tree.nodes[0]);
    } else if (place.is_pack()) {
      begin = reinterpret_cast<const char*>(&view_.tree.packs[place.index()]);
      size = offsetof(Pack, ids);
    } else {
      return;
    }
    for (std::size_t offset = 0; offset < size; offset += 64) __builtin_prefetch(begin + offset);
  }

  [[gnu::always_inline]] bool test_leaf(WideRef place) {
    if (place.is_pack()) return test_pack(view_.tree.packs[place.index()]);
    const WideList list = view_.tree.lists[place.index()];
    count_.primitives(list.count);
    bool found = false;
    for (std::uint32_t i = list.first; i < list.first + list.count; ++i) {
      found |= intersect_primitive(view_.geometry, view_.tree.list_ids[i], ray_, shear_, hit_);
      if (any_hit && found) return true;
    }
    return found;
  }

  // The corners of a pack's triangles in the space of the watertight test, where the ray is the axis; z not yet scaled.
  struct Corners {
    Lanes x[3], y[3], z[3];
  };

  template <int width>
  [[gnu::always_inline]] Corners corners(const TrianglePack<width>& pack) const {
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.z[i] = Lanes::load(pack.vertices[i][shear_.kz]) - sheared_origin_[2];
      c.x[i] = (Lanes::load(pack.vertices[i][shear_.kx]) - sheared_origin_[0]) - shear_x_ * c.z[i];
      c.y[i] = (Lanes::load(pack.vertices[i][shear_.ky]) - sheared_origin_[1]) - shear_y_ * c.z[i];
    }
    return c;
  }

  [[gnu::always_inline]] Corners corners(const SharedPack& pack) const {
    static_assert(SharedPack::slots == SharedPack::lanes);
    const Lanes z = Lanes::load(pack.vertices[shear_.kz]) - sheared_origin_[2];
    const typename Simd::Table x_of((Lanes::load(pack.vertices[shear_.kx]) - sheared_origin_[0]) - shear_x_ * z);
    const typename Simd::Table y_of((Lanes::load(pack.vertices[shear_.ky]) - sheared_origin_[1]) - shear_y_ * z);
    const typename Simd::Table z_of(z);
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.x[i] = x_of.pick(pack.corners[i]);
      c.y[i] = y_of.pick(pack.corners[i]);
      c.z[i] = z_of.pick(pack.corners[i]);
    }
    return c;
  }

  // intersect_triangle of framework/scene/intersect.h with a triangle in each lane, in its order of operations.
  [[gnu::always_inline]] bool test_pack(const Pack& pack) {
    if constexpr (!std::is_same_v<Count, CountNothing>)
      count_.primitives(static_cast<std::uint32_t>(Pack::lanes - std::count(pack.ids, pack.ids + Pack::lanes, no_id)));
    const Corners c = corners(pack);
    const Lanes(&x)[3] = c.x, (&y)[3] = c.y, (&z)[3] = c.z;
    const Lanes u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
    const Sides sides = Simd::sides(u, v, w);
    const unsigned on_edge = sides.on_edge & pack.used();
    bool found = false;
    if (on_edge != 0) [[unlikely]] {
      found = test_lanes(pack, on_edge);
      if (any_hit && found) return true;
    }
    unsigned inside = sides.same & ~sides.on_edge & pack.used();
    if (inside == 0) return found;
    const Lanes reciprocal = Lanes::set(1) / (u + v + w);
    const Lanes t = (u * (shear_z_ * z[0]) + v * (shear_z_ * z[1]) + w * (shear_z_ * z[2])) * reciprocal;
    inside &= less(Lanes::set(ray_.t_min), t) & less_equal(t, Lanes::set(hit_.t));
    if (inside == 0) return found;
    if constexpr (any_hit) {
      hit_.primitive = pack.ids[std::countr_zero(inside)];
      return true;
    }
    alignas(64) float distance[Pack::lanes];
    t.store(distance);
    int best = std::countr_zero(inside);
    for (unsigned rest = inside & (inside - 1); rest != 0; rest &= rest - 1)
      if (distance[std::countr_zero(rest)] < distance[best]) best = std::countr_zero(rest);
    if (!closer(distance[best], pack.ids[best], hit_)) return found;
    alignas(64) float b1[Pack::lanes], b2[Pack::lanes];
    (v * reciprocal).store(b1);
    (w * reciprocal).store(b2);
    hit_.t = distance[best];
    hit_.uv = {b1[best], b2[best]};
    hit_.primitive = pack.ids[best];
    return true;
  }

  // Lanes whose edge functions vanish in single precision: the scalar test turns to double for them.
  bool test_lanes(const Pack& pack, unsigned lanes) {
    bool found = false;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      float t;
      vec2 uv;
      if (!intersect_triangle(ray_, shear_, pack.vertex(lane, 0), pack.vertex(lane, 1), pack.vertex(lane, 2), hit_.t, t, uv))
        continue;
      if (!closer(t, pack.ids[lane], hit_)) continue;
      hit_.t = t;
      hit_.uv = uv;
      hit_.primitive = pack.ids[lane];
      found = true;
    }
    return found;
  }

  const View& view_;
  const Ray& ray_;
  TriangleRay shear_;  // of sheared_origin_ and the rest, set before the first leaf
  Count count_;
  const TraversalLimit limit_;
  Boxes origin_[3], reciprocal_[3];
  int near_plane_[3];
  Lanes sheared_origin_[3], shear_x_, shear_y_, shear_z_;
  Hit hit_;
};

template <class Simd, int node_width, class Pack>
constexpr WideKernels<node_width, Pack> kernels() {
  using View = WideView<node_width, Pack>;
  return {[](const View& view, const Ray& ray) -> Hit {
            if (!is_traceable(ray)) return {};
            const Hit hit = WideTraversal<Simd, node_width, Pack, false, CountNothing>(view, ray, {}).run();
            return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{};
          },
          [](const View& view, const Ray& ray) {
            return is_traceable(ray) && WideTraversal<Simd, node_width, Pack, true, CountNothing>(view, ray, {}).run();
          },
          [](const View& view, const Ray& ray, TraversalCounters& counters) -> Hit {
            if (!is_traceable(ray)) return {};
            const Hit hit = WideTraversal<Simd, node_width, Pack, false, CountWork>(view, ray, {counters}).run();
            return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{};
          },
          [](const View& view, const Ray& ray, TraversalCounters& counters) {
            return is_traceable(ray) && WideTraversal<Simd, node_width, Pack, true, CountWork>(view, ray, {counters}).run();
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
