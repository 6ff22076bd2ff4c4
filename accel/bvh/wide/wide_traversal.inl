// One ray through a wide tree, for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/bvh/wide/wide_tests.inl"

namespace etendue {
namespace {

// The most promising child that the ray meets is `next`, the others it meets are stacked; false if it meets none.
template <class Simd, int node_width, class Boxes>
[[gnu::always_inline]] inline bool step_down(const WideNode<node_width>& node, const NodeTest<Simd, node_width>& test,
                                             const Boxes& limit, WideRef& next, WaitingAny*& top) {
  Boxes near;
  const unsigned met = test.met(node, limit, near);
  if (met == 0) return false;
  const int first = std::bit_width(met) - 1;
  top = Simd::stack_places(node, met ^ (1u << first), top);
  next = node.children[first];
  return true;
}

// The child that the ray enters first is `next`, the others it meets are stacked; false if it meets none.
template <class Simd, int node_width, class Boxes>
[[gnu::always_inline]] inline bool step_down(const WideNode<node_width>& node, const NodeTest<Simd, node_width>& test,
                                             const Boxes& limit, WideRef& next, Waiting*& top) {
  Boxes near;
  const unsigned met = test.met(node, limit, near);
  if (met == 0) return false;
  int first = std::countr_zero(met);
  if ((met & (met - 1)) != 0) {
    first = Simd::template nearest<node_width>(near, met);
    top = Simd::stack_places(node, near, met & ~(1u << first), top);
  }
  next = node.children[first];
  return true;
}

// The last place stacked that a ray may enter before `limit` is `next`; false if there is none.
[[gnu::always_inline]] inline bool pop(const Waiting* bottom, float limit, Waiting*& top, WideRef& next) {
  do {
    if (top == bottom) return false;
    --top;
  } while (top->entry > limit);
  next = top->place;
  return true;
}
// Any hit will do: what waits has not come to lie too far.
[[gnu::always_inline]] inline bool pop(const WaitingAny* bottom, float, WaitingAny*& top, WideRef& next) {
  if (top == bottom) return false;
  next = (--top)->place;
  return true;
}

// Trees of one node over no more packs than this are tested whole: that takes less than to find out which packs to test.
inline constexpr std::size_t few_packs = 4;

template <class Tree>
bool has_few_packs(const Tree& tree) {
  return tree.nodes.size() == 1 && tree.packs.size() <= few_packs && tree.lists.empty();
}

// A traceable ray through such a tree.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
[[gnu::always_inline]] inline Hit trace_few(const WideView<node_width, Pack>& view, const Ray& ray, Count& count) {
  count.node();
  const LeafQuery<Simd, Pack, any_hit, Count> leaf_test(ray.origin, TriangleRay(ray.direction));
  Hit hit;
  hit.t = farthest_hit(ray);
  for (std::uint32_t i = 0; i < view.tree.packs.size(); ++i)
    if (leaf_test.test(view, ray, WideRef(WideRef::Kind::pack, i), hit, count) && any_hit) break;
  return any_hit ? hit : placed(hit);
}

// One ray on its way through a tree.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
class Traversal {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;
  using Place = std::conditional_t<any_hit, WaitingAny, Waiting>;
  using Leaf = LeafQuery<Simd, Pack, any_hit, Count>;

 public:
  Traversal(const View& view, const Ray& ray, const RayTerms<Simd>& terms, Count count)
      : view_(view),
        ray_(ray),
        slab_(ray, terms.reciprocal, terms.negative),
        limit_(terms.limit),
        count_(count),
        stack_(view.tree.depth * (node_width - 1) + node_width),
        top_(stack_.begin()) {
    hit_.t = farthest_hit(ray);
  }

  Hit run() {
    count_.node();
    const NodeTest<Simd, node_width> node_test(slab_);
    if (!step_down(view_.tree.nodes[0], node_test, Boxes::set(limit_(hit_.t)), place_, top_)) return {};
    prefetch(view_.tree, place_);
    leaf_ = LeafTerms(ray_);  // while the next node is waited for; many rays meet nothing at all
    while (go_on() && test_rare_leaves()) {
    }
    return any_hit ? hit_ : placed(hit_);
  }

 private:
  // Tests the leaf that go_on has come to, and those that wait right behind it. False where the ray has its answer.
  bool test_rare_leaves() {
    do {
      if (Leaf::test_rare(view_, ray_, leaf_.shear, place_, hit_, count_) && any_hit) return false;
      if (!pop(stack_.begin(), limit_(hit_.t), top_, place_)) return false;
    } while (place_.is_leaf() && !place_.is_pack());
    return true;
  }

  // Goes on until the ray has its answer, or to `place_`, a leaf that takes more than SIMD instructions: then true. It calls
  // nothing and keeps all in variables of its own, for which AVX-512 has registers enough.
  [[gnu::noinline, gnu::flatten]] bool go_on() {
    const View& view = view_;
    const auto& tree = view.tree;
    const WideNode<node_width>* const nodes = tree.nodes.data();
    const NodeTest<Simd, node_width> node_test(slab_);
    const Leaf leaf_test(leaf_);
    const TraversalLimit limit_beyond = limit_;
    const float t_min = leaf_.t_min;
    Count count = count_;
    Hit hit = hit_;
    Boxes far = Boxes::set(limit_beyond(hit.t));
    Place* const bottom = stack_.begin();
    Place* top = top_;
    WideRef place = place_;
    auto outcome = Leaf::Outcome::missed;
    for (;;) {
      if (!place.is_leaf()) {
        count.node();
        if (step_down(nodes[place.node()], node_test, far, place, top)) {
          prefetch(tree, place);
          continue;
        }
      } else {
        outcome = leaf_test.test_common(view, t_min, place, hit, count);
        if (outcome == Leaf::Outcome::rare) [[unlikely]]
          break;
        if (outcome == Leaf::Outcome::found) {
          if constexpr (any_hit) break;
          far = Boxes::set(limit_beyond(hit.t));
        }
      }
      if (!pop(bottom, limit_beyond(hit.t), top, place)) break;
    }
    hit_ = hit;
    top_ = top;
    place_ = place;
    return outcome == Leaf::Outcome::rare;
  }

  const View& view_;
  const Ray& ray_;
  const SlabRay slab_;
  const TraversalLimit limit_;
  LeafTerms leaf_;
  Count count_;
  Hit hit_;
  TraversalStack<Place, 256> stack_;
  Place* top_;
  WideRef place_;
};

// The nearest hit of a ray, or any one: then only Hit::primitive tells.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
[[gnu::flatten]] Hit trace(const WideView<node_width, Pack>& view, const Ray& ray, Count count) {
  if (view.tree.nodes.empty()) return {};
  const RayTerms<Simd> terms(ray, view.extent);
  if (!terms.is_traceable) return {};
  if (has_few_packs(view.tree)) return trace_few<Simd, any_hit>(view, ray, count);
  return Traversal<Simd, any_hit, node_width, Pack, Count>(view, ray, terms, count).run();
}

}  // namespace
}  // namespace etendue
