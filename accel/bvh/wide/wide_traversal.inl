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

// The child that the ray enters first is `next`, the others it meets are stacked, the second on top; false if it meets none.
template <class Simd, int node_width, class Boxes>
[[gnu::always_inline]] inline bool step_down(const WideNode<node_width>& node, const NodeTest<Simd, node_width>& test,
                                             const Boxes& limit, WideRef& next, Waiting*& top) {
  Boxes near;
  const unsigned met = test.met(node, limit, near);
  if (met == 0) return false;
  int first = std::countr_zero(met);
  if ((met & (met - 1)) != 0) {
    const auto nearest = Simd::template nearest_two<node_width>(near);
    first = nearest.first;
    top = Simd::stack_places(node, near, met & ~(1u << first | 1u << nearest.second), top);
    *top++ = {node.children[nearest.second], nearest.second_entry};
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
// Any hit will do, so that no child that waits has come to lie too far.
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

// A ray through a tree. What takes more than SIMD instructions comes after the inner loop, which calls nothing and so keeps its
// vectors in registers.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
[[gnu::always_inline]] inline Hit traverse(const WideView<node_width, Pack>& view, const Ray& ray, const RayTerms<Simd>& terms,
                                           Count& count) {
  using Boxes = typename Simd::template Floats<node_width>;
  using Place = std::conditional_t<any_hit, WaitingAny, Waiting>;
  using Leaf = LeafQuery<Simd, Pack, any_hit, Count>;
  const auto& tree = view.tree;
  const WideNode<node_width>* const nodes = tree.nodes.data();
  const NodeTest<Simd, node_width> node_test(SlabRay(ray, terms.reciprocal, terms.negative));
  TraversalStack<Place, 256> stack(tree.depth * (node_width - 1) + node_width);
  Place *const bottom = stack.begin(), *top = bottom;
  WideRef place;
  Hit hit;
  hit.t = farthest_hit(ray);
  float limit = terms.limit(hit.t);
  count.node();
  if (!step_down(nodes[0], node_test, Boxes::set(limit), place, top)) return {};
  prefetch(tree, place);
  const LeafTerms leaf_terms(ray);  // while the next node is waited for; many rays meet nothing at all
  const Leaf leaf_test(leaf_terms);
  for (;;) {
    Boxes far = Boxes::set(limit);
    auto outcome = Leaf::Outcome::missed;
    for (;;) {
      if (!place.is_leaf()) {
        count.node();
        if (step_down(nodes[place.node()], node_test, far, place, top)) {
          prefetch(tree, place);
          if (!any_hit && top != bottom) prefetch(tree, top[-1].place);  // it mostly comes after that
          continue;
        }
      } else {
        outcome = leaf_test.test_common(view, leaf_terms.t_min, place, hit, count);
        if (outcome == Leaf::Outcome::rare) [[unlikely]]
          break;
        if (outcome == Leaf::Outcome::found) {
          if constexpr (any_hit) return hit;
          limit = terms.limit(hit.t);
          far = Boxes::set(limit);
        }
      }
      if (!pop(bottom, limit, top, place)) break;
    }
    if (outcome != Leaf::Outcome::rare) break;
    Hit lowered = hit;  // a copy: its address goes to a call
    const bool found = Leaf::test_rare(view, ray, leaf_terms.shear, place, lowered, count);
    hit = lowered;
    if (any_hit && found) break;
    limit = terms.limit(hit.t);
    if (!pop(bottom, limit, top, place)) break;
  }
  return any_hit ? hit : placed(hit);
}

// The nearest hit of a ray, or any one: then only Hit::primitive tells.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
[[gnu::flatten]] Hit trace(const WideView<node_width, Pack>& view, const Ray& ray, Count count) {
  if (view.tree.nodes.empty()) return {};
  const RayTerms<Simd> terms(ray, view.extent);
  if (!terms.is_traceable) return {};
  if (has_few_packs(view.tree)) return trace_few<Simd, any_hit>(view, ray, count);
  return traverse<Simd, any_hit>(view, ray, terms, count);
}

}  // namespace
}  // namespace etendue
