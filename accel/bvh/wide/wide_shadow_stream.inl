// Many shadow rays through a wide tree together, for one instruction set; included like wide_tests.inl.
//
// As in wide_stream.inl, a node is visited once for all rays that meet it ([Barringer2014]). Any hit will do, so no order of
// visits is kept: the leaves among a node's children are tested at once, leaf by leaf, as a list of pairs of leaf and ray.
// There is no branch on how a test ends, which nothing predicts, so the processor overlaps the tests; all lines of the leaves
// are asked for beforehand. Testing a ray again that an earlier pair has found occluded costs less than
// a branch would.
#pragma once

#include "accel/bvh/wide/wide_tests.inl"

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
  WideShadowStream(const View& view, std::span<const Ray> rays) : view_(view), rays_(rays), space_(space()) {}

  // To be called before rays are added: not every batch comes to that.
  void make_room() {
    space_.travellers.resize(most);
    space_.indices.resize(most);
    reserve(space_.met, most);
  }

  // Takes a ray in, up to `most` until the next run, and visits the root with it. False where it meets nothing there; then it
  // is not kept: under an open sky that is all that most rays take. The node test reads terms of its own, as where the
  // traveller lies depends on how the last test ended.
  [[gnu::always_inline]] bool add(std::size_t index) {
    const Ray& ray = rays_[index];
    const RayTerms<Simd> terms(ray, view_.extent);
    const SlabRay slab(ray, terms.reciprocal, terms.negative);
    const float far = terms.limit(farthest_hit(ray));
    Boxes near;
    const unsigned met = NodeTest<Simd, node_width>(slab).met(view_.tree.nodes[0], Boxes::set(far), near);
    Traveller& traveller = space_.travellers[size_];
    traveller.slab = slab;
    traveller.far = far;
    const bool goes_on = terms.is_traceable && met != 0;
    space_.indices[size_] = static_cast<std::uint32_t>(index);
    space_.met[size_] = met;
    size_ += goes_on;
    return goes_on;
  }

  std::size_t size() const { return size_; }

  // Traces the rays taken in: `answer(index, hit)` is called once for each.
  template <class Answer>
  void run(const Answer& answer) {
    const auto count = static_cast<std::uint32_t>(size_);
    if (count == 0) return;
    reserve(space_.ids, count);
    std::copy_n(all_places().begin(), count, space_.ids.begin());
    space_.occluded.assign(count, 0);
    space_.leaf_terms.resize(most);
    for (std::uint32_t i = 0; i < count; ++i) space_.leaf_terms[i] = LeafTerms(rays_[space_.indices[i]]);
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
    size_ = 0;
  }

 private:
  // Holds what visits of nodes read of a ray, in one cache line.
  struct alignas(64) Traveller {
    SlabRay slab;
    float far;  // limit(t_max); of occluded rays -infinity: they meet nothing any more
  };
  struct Job {
    std::uint32_t node;
    std::uint32_t first, count;  // of its list
    std::uint32_t free;          // from where on `ids` is free while the job lasts
  };
  // Working space is the thread's and kept.
  struct Space {
    // By ray taken in.
    std::vector<Traveller> travellers;
    std::vector<LeafTerms> leaf_terms;
    std::vector<std::uint32_t> indices;  // in the batch
    std::vector<std::uint8_t> occluded;
    std::vector<std::uint32_t> ids;  // lists of rays
    std::vector<Job> jobs;
    // The visit in hand has the children met by each ray of its list, and pairs of a leaf and a ray's place in the list.
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
    const unsigned met = is_root ? met_at_root(job) : test_all(node, job);
    const unsigned leaves = met & Simd::leaves(node), inner = met & ~leaves;
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

  // Takes up what `add` has found.
  unsigned met_at_root(const Job& job) {
    unsigned any = 0;
    for (std::uint32_t i = 0; i < job.count; ++i) any |= space_.met[i];
    for (std::uint32_t i = job.count; i < (job.count + 15) / 16 * 16; ++i) space_.met[i] = 0;
    return any;
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
      const bool found = LeafQuery<Simd, Pack, true, CountNothing>::occluded(view_, rays_[space_.indices[id]],
                                                                             space_.leaf_terms[id], space_.paired_leaves[i]);
      space_.travellers[id].far = std::min(space_.travellers[id].far, far_of[found]);
      space_.occluded[id] |= static_cast<std::uint8_t>(found);
      space_.met[place] &= static_cast<std::uint32_t>(found) - 1u;
    }
  }

  const View& view_;
  const std::span<const Ray> rays_;
  Space& space_;
  std::size_t size_ = 0;  // rays taken in
};

}  // namespace
}  // namespace etendue
