// Many rays through a wide tree together, for one instruction set; included like wide_tests.inl.
//
// A node is visited once for all rays of the batch that meet it, which are then told apart by the children they meet
// ([Barringer2014]). One ray's visit does not wait for another's, so the processor overlaps them where a single ray would wait
// for its own last step; and a node's or a pack's cache lines are fetched once. Children are taken by the nearest entry of any
// of their rays; for any hit by their promise, and leaves at once, as the order is of no account. Answers are those of single
// rays, to the bit.
#pragma once

#include "accel/ray/wide_tests.inl"

namespace etendue {
namespace {

// Rays that share their visits: enough for neighbours in the tree to meet, few enough to stay in the second cache.
inline constexpr std::size_t stream_size = 2048;

template <class Simd, int node_width, class Pack, bool any_hit>
class WideStream {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;

 public:
  explicit WideStream(const View& view)
      : view_(view),
        travellers_(space().travellers),
        ids_(space().ids),
        nears_(space().nears),
        met_(space().met),
        entries_(space().entries),
        jobs_(space().jobs) {
    travellers_.clear();
  }

  // Takes a ray in, up to stream_size until the next run.
  void add(const Ray& ray, std::size_t index) {
    travellers_.emplace_back(ray, view_.extent, static_cast<std::uint32_t>(index));
  }

  std::size_t size() const { return travellers_.size(); }

  // Traces the rays taken in: `answer(index, hit)` is called once for each.
  template <class Answer>
  void run(const Answer& answer) {
    if (travellers_.empty()) return;
    reserve(travellers_.size());
    for (std::uint32_t i = 0; i < travellers_.size(); ++i) {
      ids_[i] = i;
      if constexpr (!any_hit) nears_[i] = travellers_[i].slab.t_min;
    }
    const auto count = static_cast<std::uint32_t>(travellers_.size());
    jobs_.assign(1, {WideRef(WideRef::Kind::node, 0), 0, count, count, 0});
    while (!jobs_.empty()) {
      const Job job = jobs_.back();
      jobs_.pop_back();
      if (!jobs_.empty()) prefetch(view_.tree, jobs_.back().place);
      if (job.place.is_leaf())
        test_leaf(job);
      else
        visit(job);
    }
    for (const Traveller& traveller : travellers_) answer(traveller.index, traveller.hit);
    travellers_.clear();
  }

 private:
  struct alignas(64) Traveller {
    // What visits of nodes read, in one line.
    SlabTerms<node_width> slab;
    float far;            // before_padding(limit, hit.t); nothing is met any more once any hit is found
    std::uint32_t index;  // in the batch
    // What tests of leaves read; many rays come to none.
    bool has_shear = false;
    TriangleRay shear;
    TraversalLimit limit;
    Ray ray;
    Hit hit;

    Traveller(const Ray& r, float extent, std::uint32_t i) : slab(r), index(i), limit(r, extent), ray(r) {
      hit.t = std::min(r.t_max, std::numeric_limits<float>::max());
      far = before_padding(limit, hit.t);
    }
  };
  struct Job {
    WideRef place;
    std::uint32_t first, count;  // of its list
    std::uint32_t free;          // from where on ids_ is free while the job lasts
    float near;                  // of all on the list
  };

  // Working space is the thread's and kept.
  struct Space {
    std::vector<Traveller> travellers;
    std::vector<std::uint32_t> ids;
    std::vector<float> nears;
    std::vector<std::uint32_t> met;
    std::vector<float> entries;
    std::vector<Job> jobs;
  };
  static Space& space() {
    thread_local Space space;
    return space;
  }

  // A vector may be written past a list's end by a whole SIMD register.
  void reserve(std::size_t size) {
    if (ids_.size() >= size + 16) return;
    ids_.resize(2 * size + 16);
    if constexpr (!any_hit) nears_.resize(ids_.size());
  }

  // Lists the rays that meet each child, one list after another beyond all that are still needed.
  void visit(const Job& job) {
    const WideNode<node_width>& node = view_.tree.nodes[job.place.index()];
    unsigned any = test_all(node, job);
    if constexpr (any_hit) {
      const unsigned leaves = any & Simd::leaves(node);
      if (leaves != 0) test_leaves(node, job, leaves);
      any &= ~leaves;
    }
    reserve(job.free + static_cast<std::size_t>(std::popcount(any)) * job.count);
    const std::size_t before = jobs_.size();
    std::uint32_t free = job.free;
    for (unsigned rest = any; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      const std::uint32_t* const ids = ids_.data() + job.first;
      std::uint32_t count;
      float nearest = 0;
      if constexpr (any_hit)
        count = Simd::collect(met_.data(), ids, job.count, child, ids_.data() + free);
      else
        count = Simd::template collect<node_width>(met_.data(), ids, entries_.data(), job.count, child, ids_.data() + free,
                                                   nears_.data() + free, nearest);
      jobs_.push_back({node.children[child], free, count, 0, nearest});
      free += count;
    }
    for (std::size_t i = before; i < jobs_.size(); ++i) jobs_[i].free = free;
    if constexpr (!any_hit)
      std::sort(jobs_.begin() + static_cast<std::ptrdiff_t>(before), jobs_.end(),
                [](const Job& a, const Job& b) { return a.near > b.near; });
  }

  // Writes for each ray of a list which children it meets (and where it enters them); answers which are met by any.
  [[gnu::flatten]] unsigned test_all(const WideNode<node_width>& node, const Job& job) {
    if (met_.size() < job.count + 16) {
      met_.resize(2 * job.count + 16);
      if constexpr (!any_hit) entries_.resize(node_width * met_.size());
    }
    unsigned any = 0;
    for (std::uint32_t i = 0; i < job.count; ++i) {
      const Traveller& traveller = travellers_[ids_[job.first + i]];
      Boxes near;
      any |= met_[i] = NodeTest<Simd, node_width>(traveller.slab).met(node, Boxes::set(traveller.far), near);
      if constexpr (!any_hit) near.store_anywhere(entries_.data() + i * node_width);
    }
    for (std::uint32_t i = job.count; i < (job.count + 15) / 16 * 16; ++i) met_[i] = 0;
    return any;
  }

  // Any hit: each ray's leaves in turn, while its terms are at hand; that done, a ray that is hit meets nothing.
  [[gnu::flatten]] void test_leaves(const WideNode<node_width>& node, const Job& job, unsigned leaves) {
    for (unsigned rest = leaves; rest != 0; rest &= rest - 1) prefetch(view_.tree, node.children[std::countr_zero(rest)]);
    for (std::uint32_t i = 0; i < job.count; ++i) {
      unsigned met = met_[i] & leaves;
      if (met == 0) continue;
      Traveller& traveller = travellers_[ids_[job.first + i]];
      LeafTest<Simd, Pack, any_hit, CountNothing> test;
      prepare(test, traveller);
      CountNothing nothing;
      do {
        const int child = std::bit_width(met) - 1;
        met ^= 1u << child;
        if (!test.test(view_, traveller.ray, node.children[child], traveller.hit, nothing)) continue;
        traveller.far = -infinity;
        met_[i] = met = 0;
      } while (met != 0);
    }
  }

  // Nearest hits: a leaf's rays in turn.
  [[gnu::flatten]] void test_leaf(const Job& job) {
    for (std::uint32_t i = job.first; i < job.first + job.count; ++i) {
      Traveller& traveller = travellers_[ids_[i]];
      if (nears_[i] > traveller.far * slab_pad) continue;
      LeafTest<Simd, Pack, any_hit, CountNothing> test;
      prepare(test, traveller);
      CountNothing nothing;
      if (test.test(view_, traveller.ray, job.place, traveller.hit, nothing))
        traveller.far = before_padding(traveller.limit, traveller.hit.t);
    }
  }

  [[gnu::always_inline]] static void prepare(LeafTest<Simd, Pack, any_hit, CountNothing>& test, Traveller& traveller) {
    if (!traveller.has_shear) {
      traveller.shear = TriangleRay(traveller.ray.direction);
      traveller.has_shear = true;
    }
    test.prepare(traveller.ray, traveller.shear);
  }

  const View& view_;
  std::vector<Traveller>& travellers_;
  // Lists of rays: who they are, and where they enter the list's box.
  std::vector<std::uint32_t>& ids_;
  std::vector<float>& nears_;
  // Of the visit in hand, by ray: the children met, and where they are entered.
  std::vector<std::uint32_t>& met_;
  std::vector<float>& entries_;
  std::vector<Job>& jobs_;
};

}  // namespace
}  // namespace etendue
