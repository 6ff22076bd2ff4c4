// Many shadow rays through a wide tree together, for one instruction set; included like wide_tests.inl.
//
// As in wide_stream.inl, a node is visited once for all rays that meet it ([Barringer2014]). Any hit will do, so no order of
// visits is kept: the leaves among a node's children are tested at once, leaf by leaf, as a list of pairs of leaf and ray, one
// after another and with no branch on how a test ends. Nothing predicts that; without it the processor overlaps the tests, and
// all lines of the leaves are asked for beforehand. To test some rays again that an earlier pair has found occluded costs less
// than a branch would.
#pragma once

#include "accel/ray/wide_tests.inl"

namespace etendue {
namespace {

template <class Simd, int node_width, class Pack>
class WideShadowStream {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;

 public:
  // Rays that share their visits: enough for neighbours in the tree to meet, few enough to stay in the second cache.
  static constexpr std::size_t most = 4096;

  // `rays`: the batch, of which some will be added.
  WideShadowStream(const View& view, std::span<const Ray> rays) : view_(view), rays_(rays), space_(space()) {
    space_.travellers.clear();
    space_.indices.clear();
  }

  // Takes a ray in, up to `most` until the next run.
  void add(std::size_t index) {
    space_.travellers.emplace_back(rays_[index], view_.extent);
    space_.indices.push_back(static_cast<std::uint32_t>(index));
  }

  std::size_t size() const { return space_.travellers.size(); }

  // Traces the rays taken in: `answer(index, hit)` is called once for each.
  template <class Answer>
  void run(const Answer& answer) {
    const auto count = static_cast<std::uint32_t>(size());
    if (count == 0) return;
    reserve(space_.ids, count);
    std::copy_n(all_places().begin(), count, space_.ids.begin());
    space_.occluded.assign(count, 0);
    if (space_.leaf_terms.size() < count) space_.leaf_terms.resize(most);
    space_.jobs.clear();
    visit<true>({0, 0, count, count});
    while (!space_.jobs.empty()) {
      const Job job = space_.jobs.back();
      space_.jobs.pop_back();
      if (!space_.jobs.empty()) prefetch_lines<sizeof(WideNode<node_width>)>(&view_.tree.nodes[space_.jobs.back().node]);
      visit<false>(job);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      Hit hit;
      if (space_.occluded[i] != 0) hit.primitive = 0;
      answer(space_.indices[i], hit);
    }
    space_.travellers.clear();
    space_.indices.clear();
  }

 private:
  // What visits of nodes read of a ray, in one line.
  struct alignas(64) Traveller {
    SlabTerms<node_width> slab;
    float far;  // before_padding(limit, t_max); of occluded rays -infinity: they meet nothing any more

    Traveller(const Ray& ray, float extent) : slab(ray), far(before_padding(TraversalLimit(ray, extent), farthest_hit(ray))) {}
  };
  struct Job {
    std::uint32_t node;
    std::uint32_t first, count;  // of its list
    std::uint32_t free;          // from where on `ids` is free while the job lasts
  };
  // Working space is the thread's and kept.
  struct Space {
    // By ray taken in. Terms of those alone that meet a child of the root.
    std::vector<Traveller> travellers;
    std::vector<LeafTerms> leaf_terms;
    std::vector<std::uint32_t> indices;  // in the batch
    std::vector<std::uint8_t> occluded;
    std::vector<std::uint32_t> ids;  // lists of rays
    std::vector<Job> jobs;
    // Of the visit in hand: by ray of its list the children met, and the pairs of a leaf and a ray, by its place in the list.
    std::vector<std::uint32_t> met;
    std::vector<WideRef> paired_leaves;
    std::vector<std::uint32_t> paired_places;
  };
  static Space& space() {
    thread_local Space space;
    return space;
  }

  // 0, 1, 2 …: the places in a list.
  static const std::array<std::uint32_t, most + 16>& all_places() {
    static constexpr auto places = [] {
      std::array<std::uint32_t, most + 16> values{};
      for (std::uint32_t i = 0; i < values.size(); ++i) values[i] = i;
      return values;
    }();
    return places;
  }

  // A vector may be written past a list's end by a whole SIMD register.
  template <class T>
  static void reserve(std::vector<T>& vector, std::size_t size) {
    if (vector.size() < size + 16) vector.resize(2 * size + 16);
  }

  template <bool is_root>
  void visit(const Job job) {
    const WideNode<node_width>& node = view_.tree.nodes[job.node];
    const unsigned met = test_all(node, job), leaves = met & Simd::leaves(node), inner = met & ~leaves;
    if constexpr (is_root) prepare_for_leaves(job);
    if (leaves != 0) test_leaves(job, pair_with_leaves(node, job, leaves));
    // A list of the rays that meet each inner node, one after another beyond all that are still needed.
    reserve(space_.ids, job.free + static_cast<std::size_t>(std::popcount(inner)) * job.count);
    const std::size_t before = space_.jobs.size();
    std::uint32_t free = job.free;
    for (unsigned rest = inner; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      std::uint32_t* const ids = space_.ids.data();
      const std::uint32_t count = Simd::collect(space_.met.data(), ids + job.first, job.count, child, ids + free);
      if (count == 0) continue;  // the leaves have answered all
      space_.jobs.push_back({node.children[child].index(), free, count, 0});
      free += count;
    }
    for (std::size_t i = before; i < space_.jobs.size(); ++i) space_.jobs[i].free = free;
  }

  // Writes for each ray of a list which children it meets; answers which are met by any.
  [[gnu::flatten]] unsigned test_all(const WideNode<node_width>& node, const Job& job) {
    reserve(space_.met, job.count);
    const std::uint32_t* const ids = space_.ids.data() + job.first;
    const Traveller* const travellers = space_.travellers.data();
    std::uint32_t* const met = space_.met.data();
    unsigned any = 0;
    for (std::uint32_t i = 0; i < job.count; ++i) {
      const Traveller& traveller = travellers[ids[i]];
      Boxes near;
      any |= met[i] = NodeTest<Simd, node_width>(traveller.slab).met(node, Boxes::set(traveller.far), near);
    }
    for (std::uint32_t i = job.count; i < (job.count + 15) / 16 * 16; ++i) met[i] = 0;
    return any;
  }

  // At the root, where a ray's place is its id. Many rays meet nothing there.
  void prepare_for_leaves(const Job& job) {
    reserve(space_.ids, 2 * static_cast<std::size_t>(job.count));
    std::uint32_t* const met_any = space_.ids.data() + job.free;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < job.count; ++i) {
      met_any[count] = i;
      count += space_.met[i] != 0;
    }
    for (std::uint32_t i = 0; i < count; ++i) space_.leaf_terms[met_any[i]] = LeafTerms(rays_[space_.indices[met_any[i]]]);
  }

  // Answers how many pairs there are.
  std::uint32_t pair_with_leaves(const WideNode<node_width>& node, const Job& job, unsigned leaves) {
    const std::size_t pairs_at_most = static_cast<std::size_t>(std::popcount(leaves)) * job.count;
    reserve(space_.paired_leaves, pairs_at_most);
    reserve(space_.paired_places, pairs_at_most);
    std::uint32_t pairs = 0;
    for (unsigned rest = leaves; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      const WideRef leaf = node.children[child];
      prefetch(view_.tree, leaf);
      const std::uint32_t count =
          Simd::collect(space_.met.data(), all_places().data(), job.count, child, space_.paired_places.data() + pairs);
      WideRef* const to = space_.paired_leaves.data() + pairs;
      for (std::uint32_t i = 0; i < count; i += 16) std::fill_n(to + i, 16, leaf);
      pairs += count;
    }
    return pairs;
  }

  [[gnu::flatten]] void test_leaves(const Job& job, std::uint32_t pairs) {
    static constexpr float far_of[] = {infinity, -infinity};
    const std::uint32_t* const ids = space_.ids.data() + job.first;
    for (std::uint32_t i = 0; i < pairs; ++i) {
      const std::uint32_t place = space_.paired_places[i], id = ids[place];
      const bool found = LeafTest<Simd, Pack, true, CountNothing>::occluded(view_, rays_[space_.indices[id]],
                                                                            space_.leaf_terms[id], space_.paired_leaves[i]);
      space_.travellers[id].far = std::min(space_.travellers[id].far, far_of[found]);
      space_.occluded[id] |= static_cast<std::uint8_t>(found);
      space_.met[place] &= static_cast<std::uint32_t>(found) - 1u;
    }
  }

  const View& view_;
  const std::span<const Ray> rays_;
  Space& space_;
};

}  // namespace
}  // namespace etendue
