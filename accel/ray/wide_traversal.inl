// One ray through a wide tree, for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/ray/wide_tests.inl"

namespace etendue {
namespace {

// The most promising child that the ray meets is `next`, the others it meets are stacked; false if it meets none.
template <class Simd, int node_width, class Boxes>
[[gnu::always_inline]] inline bool step_down(const WideNode<node_width>& node, const NodeTest<Simd, node_width>& test,
                                             const Boxes& far, WideRef& next, WaitingAny*& top) {
  Boxes near;
  const unsigned met = test.met(node, far, near);
  if (met == 0) return false;
  const int first = std::bit_width(met) - 1;
  top = Simd::stack_places(node, met ^ (1u << first), top);
  next = node.children[first];
  return true;
}

// The child that the ray enters first is `next`, the others it meets are stacked; false if it meets none.
template <class Simd, int node_width, class Boxes>
[[gnu::always_inline]] inline bool step_down(const WideNode<node_width>& node, const NodeTest<Simd, node_width>& test,
                                             const Boxes& far, WideRef& next, Waiting*& top) {
  Boxes near;
  const unsigned met = test.met(node, far, near);
  if (met == 0) return false;
  int first = std::countr_zero(met);
  if ((met & (met - 1)) != 0) {
    first = Simd::template nearest<node_width>(near, met);
    top = Simd::stack_places(node, near, met & ~(1u << first), top);
  }
  next = node.children[first];
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
  LeafTest<Simd, Pack, any_hit, Count> leaf_test;
  leaf_test.prepare(ray, TriangleRay(ray.direction));
  Hit hit;
  hit.t = farthest_hit(ray);
  for (std::uint32_t i = 0; i < view.tree.packs.size(); ++i)
    if (leaf_test.test(view, ray, WideRef(WideRef::Kind::pack, i), hit, count) && any_hit) break;
  return any_hit ? hit : placed(hit);
}

// The nearest hit of a ray, or any one: then only Hit::primitive tells. All that the loop needs is local, so that it stays in
// registers.
template <class Simd, bool any_hit, int node_width, class Pack, class Count>
[[gnu::flatten]] Hit trace(const WideView<node_width, Pack>& view, const Ray& ray, Count count) {
  using Boxes = typename Simd::template Floats<node_width>;
  using Place = std::conditional_t<any_hit, WaitingAny, Waiting>;
  const auto& tree = view.tree;
  if (tree.nodes.empty()) return {};
  const RayTerms<Simd> terms(ray, view.extent);
  if (!terms.is_traceable) return {};
  if (has_few_packs(tree)) return trace_few<Simd, any_hit>(view, ray, count);
  const SlabTerms<node_width> slab(ray, terms);
  const NodeTest<Simd, node_width> node_test(slab);
  LeafTest<Simd, Pack, any_hit, Count> leaf_test;
  const TraversalLimit limit_beyond = terms.limit;
  Hit hit;
  hit.t = farthest_hit(ray);
  Boxes far = Boxes::set(before_padding(limit_beyond, hit.t));
  TraversalStack<Place, 256> stack(tree.depth * (node_width - 1) + node_width);
  Place* const bottom = stack.begin();
  Place* top = bottom;
  WideRef place;
  count.node();
  if (!step_down(tree.nodes[0], node_test, far, place, top)) return {};
  prefetch(tree, place);
  leaf_test.prepare(ray, TriangleRay(ray.direction));  // while the next node is waited for; many rays meet nothing at all
  for (;;) {
    if (!place.is_leaf()) {
      count.node();
      const WideNode<node_width>& node = tree.nodes[place.index()];
      if (step_down(node, node_test, far, place, top)) {
        prefetch(tree, place);
        continue;
      }
    } else {
      if (leaf_test.test(view, ray, place, hit, count)) {
        if constexpr (any_hit) return hit;
        far = Boxes::set(before_padding(limit_beyond, hit.t));
      }
    }
    if constexpr (any_hit) {
      if (top == bottom) return {};
      place = (--top)->place;
    } else {
      const float limit = limit_beyond(hit.t);
      do {
        if (top == bottom) return placed(hit);
        --top;
      } while (top->entry > limit);
      place = top->place;
    }
  }
}

}  // namespace
}  // namespace etendue
