// The traversal of wide trees, for one instruction set: included once by each wide_isa_*.cpp, which the build compiles for its set.
// All is in an unnamed namespace, so that no code of one set can stand in for another's when the program is linked.
//
// `Simd::Floats<width>` is a vector of floats: load, set, store, + - * /, `larger` and `smaller` (which answer their second
// operand when one is NaN, as x86 does), and comparisons that give a bit per lane. Each operation rounds by itself (the project is
// compiled without FMA contraction), so all instruction sets give the same bits, and those of the scalar tests.

namespace etendue {
namespace {

struct Waiting {
  WideRef place;
  float entry;
};

template <class Simd, int node_width, int pack_width, bool any_hit, class Count>
class WideTraversal {
  using View = WideView<node_width, pack_width>;
  using Boxes = typename Simd::template Floats<node_width>;
  using Lanes = typename Simd::template Floats<pack_width>;

 public:
  WideTraversal(const View& view, const Ray& ray, Count count)
      : view_(view), ray_(ray), shear_(ray.direction), count_(count), limit_(ray, view.extent) {
    for (int axis = 0; axis < 3; ++axis) {
      const float reciprocal = 1.0f / ray.direction[axis];
      origin_[axis] = Boxes::set(ray.origin[axis]);
      near_reciprocal_[axis] = Boxes::set(reciprocal);
      far_reciprocal_[axis] = Boxes::set(reciprocal * slab_pad);
      near_plane_[axis] = 2 * axis + (std::signbit(ray.direction[axis]) ? 1 : 0);
    }
    sheared_origin_[0] = Lanes::set(ray.origin[shear_.kx]);
    sheared_origin_[1] = Lanes::set(ray.origin[shear_.ky]);
    sheared_origin_[2] = Lanes::set(ray.origin[shear_.kz]);
    shear_x_ = Lanes::set(shear_.sx);
    shear_y_ = Lanes::set(shear_.sy);
    shear_z_ = Lanes::set(shear_.sz);
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
    for (;;) {
      if (!place.is_leaf()) {
        if (visit(tree.nodes[place.index()], t_min, t_max, place, top)) continue;
      } else if (test_leaf(place)) {
        if constexpr (any_hit) return hit_;
        t_max = Boxes::set(limit_(hit_.t));
      }
      const float limit = limit_(hit_.t);
      do {
        if (top == bottom) return hit_;
        --top;
      } while (!any_hit && top->entry > limit);
      place = top->place;
    }
  }

 private:
  // Tests the children of a node, stacks all that are met but the one to go on to, and says whether there is one.
  [[gnu::always_inline]] bool visit(const WideNode<node_width>& node, const Boxes& t_min, const Boxes& t_max, WideRef& next, Waiting*& top) {
    count_.node();
    Boxes near = t_min, far = t_max;
    for (int axis = 0; axis < 3; ++axis) {
      const int plane = near_plane_[axis];
      near = larger((Boxes::load(node.planes[plane]) - origin_[axis]) * near_reciprocal_[axis], near);
      far = smaller((Boxes::load(node.planes[plane ^ 1]) - origin_[axis]) * far_reciprocal_[axis], far);
    }
    const unsigned met = less_equal(near, far);
    if (met == 0) return false;
    int first = std::countr_zero(met);
    if (const unsigned others = met & (met - 1); others != 0) {
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
      size = sizeof(view_.tree.packs[0]);
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

  // intersect_triangle of framework/scene/intersect.h with a triangle in each lane, in its order of operations.
  [[gnu::always_inline]] bool test_pack(const TrianglePack<pack_width>& pack) {
    if constexpr (!std::is_same_v<Count, CountNothing>)
      count_.primitives(static_cast<std::uint32_t>(pack_width - std::count(pack.ids, pack.ids + pack_width, no_id)));
    Lanes x[3], y[3], z[3];
    for (int vertex = 0; vertex < 3; ++vertex) {
      z[vertex] = Lanes::load(pack.vertices[vertex][shear_.kz]) - sheared_origin_[2];
      x[vertex] = (Lanes::load(pack.vertices[vertex][shear_.kx]) - sheared_origin_[0]) - shear_x_ * z[vertex];
      y[vertex] = (Lanes::load(pack.vertices[vertex][shear_.ky]) - sheared_origin_[1]) - shear_y_ * z[vertex];
    }
    const Lanes u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
    const Lanes zero = Lanes::set(0);
    const unsigned on_edge = equal(u, zero) | equal(v, zero) | equal(w, zero);
    bool found = false;
    if (on_edge != 0) [[unlikely]] {
      found = test_lanes(pack, on_edge);
      if (any_hit && found) return true;
    }
    const unsigned below = less(u, zero) | less(v, zero) | less(w, zero);
    const unsigned above = less(zero, u) | less(zero, v) | less(zero, w);
    unsigned inside = (below ^ above) & ~on_edge;
    if (inside == 0) return found;
    const Lanes reciprocal = Lanes::set(1) / (u + v + w);
    const Lanes t = (u * (shear_z_ * z[0]) + v * (shear_z_ * z[1]) + w * (shear_z_ * z[2])) * reciprocal;
    inside &= less(Lanes::set(ray_.t_min), t) & less_equal(t, Lanes::set(hit_.t));
    if (inside == 0) return found;
    if constexpr (any_hit) {
      hit_.primitive = pack.ids[std::countr_zero(inside)];
      return true;
    }
    alignas(64) float distance[pack_width];
    t.store(distance);
    int best = std::countr_zero(inside);
    for (unsigned rest = inside & (inside - 1); rest != 0; rest &= rest - 1)
      if (distance[std::countr_zero(rest)] < distance[best]) best = std::countr_zero(rest);
    if (!closer(distance[best], pack.ids[best], hit_)) return found;
    alignas(64) float b1[pack_width], b2[pack_width];
    (v * reciprocal).store(b1);
    (w * reciprocal).store(b2);
    hit_.t = distance[best];
    hit_.uv = {b1[best], b2[best]};
    hit_.primitive = pack.ids[best];
    return true;
  }

  // Lanes whose edge functions vanish in single precision: the scalar test turns to double for them.
  bool test_lanes(const TrianglePack<pack_width>& pack, unsigned lanes) {
    bool found = false;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      const auto vertex = [&](int i) { return vec3(pack.vertices[i][0][lane], pack.vertices[i][1][lane], pack.vertices[i][2][lane]); };
      float t;
      vec2 uv;
      if (!intersect_triangle(ray_, shear_, vertex(0), vertex(1), vertex(2), hit_.t, t, uv)) continue;
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
  const TriangleRay shear_;
  Count count_;
  const TraversalLimit limit_;
  Boxes origin_[3], near_reciprocal_[3], far_reciprocal_[3];
  int near_plane_[3];
  Lanes sheared_origin_[3], shear_x_, shear_y_, shear_z_;
  Hit hit_;
};

template <class Simd, int node_width, int pack_width>
constexpr WideKernels<node_width, pack_width> kernels() {
  using View = WideView<node_width, pack_width>;
  return {[](const View& view, const Ray& ray) -> Hit {
            if (!is_traceable(ray)) return {};
            const Hit hit = WideTraversal<Simd, node_width, pack_width, false, CountNothing>(view, ray, {}).run();
            return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{};
          },
          [](const View& view, const Ray& ray) {
            return is_traceable(ray) && WideTraversal<Simd, node_width, pack_width, true, CountNothing>(view, ray, {}).run();
          },
          [](const View& view, const Ray& ray, TraversalCounters& counters) -> Hit {
            if (!is_traceable(ray)) return {};
            const Hit hit = WideTraversal<Simd, node_width, pack_width, false, CountWork>(view, ray, {counters}).run();
            return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{};
          },
          [](const View& view, const Ray& ray, TraversalCounters& counters) {
            return is_traceable(ray) && WideTraversal<Simd, node_width, pack_width, true, CountWork>(view, ray, {counters}).run();
          }};
}

template <class Simd>
const WideKernelSet& kernel_set() {
  static constexpr WideKernelSet set{kernels<Simd, 4, 4>(), kernels<Simd, 8, 8>(), kernels<Simd, 16, 8>()};
  return set;
}

}  // namespace
}  // namespace etendue
