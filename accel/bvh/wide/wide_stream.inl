// The nearest hits of many rays through a wide tree together, for one instruction set; included like wide_tests.inl.
//
// A node is visited once for all rays of the batch that meet it, which are then told apart by the children they meet
// ([Barringer2014]). One ray's visit does not wait for another's, so the processor overlaps them where a single ray would wait
// for its own last step; and a node's or a pack's cache lines are fetched once. Children are taken by the nearest entry of any
// of their rays. Answers are those of single rays, to the bit. Shadow rays go by wide_shadow_stream.inl.
#pragma once

#include "accel/bvh/wide/wide_tests.inl"

namespace etendue {
namespace {

template <class Simd, int node_width, class Pack>
class WideStream {
  using View = WideView<node_width, Pack>;
  using Boxes = typename Simd::template Floats<node_width>;

 public:
  // Rays that share their visits: enough for neighbours in the tree to meet, few enough to stay in the second cache.
  static constexpr std::size_t most = 2048;

  // `rays`: the batch, of which some will be added.
  WideStream(const View& view, std::span<const Ray> rays)
      : view_(view),
        rays_(rays),
        travellers_(space().travellers),
        ids_(space().ids),
        nears_(space().nears),
        met_(space().met),
        entries_(space().entries),
        jobs_(space().jobs) {
    travellers_.clear();
  }

  // Takes a ray in, up to `most` until the next run. False where it can meet nothing.
  bool add(std::size_t index) {
    const RayTerms<Simd> terms(rays_[index], view_.extent);
    if (terms.is_traceable) travellers_.emplace_back(rays_[index], terms, static_cast<std::uint32_t>(index));
    return terms.is_traceable;
  }

  std::size_t size() const { return travellers_.size(); }

  // Traces the rays taken in: `answer(index, hit)` is called once for each.
  template <class Answer>
  void run(const Answer& answer) {
    if (travellers_.empty()) return;
    reserve(travellers_.size());
    for (std::uint32_t i = 0; i < travellers_.size(); ++i) {
      ids_[i] = i;
      nears_[i] = travellers_[i].slab.t_min;
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
    // Visits of nodes read this, which lies in one cache line.
    SlabRay slab;
    float far;            // limit(hit.t)
    std::uint32_t index;  // in the batch
    // Tests of leaves read this; many rays come to none.
    bool has_shear = false;
    TriangleRay shear;
    TraversalLimit limit;
    Ray ray;
    Hit hit;

    Traveller(const Ray& r, const RayTerms<Simd>& terms, std::uint32_t i)
        : slab(r, terms.reciprocal, terms.negative), index(i), limit(terms.limit), ray(r) {
      hit.t = farthest_hit(r);
      far = limit(hit.t);
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
    nears_.resize(ids_.size());
  }

  // Lists the rays that meet each child, one list after another beyond all that are still needed.
  void visit(const Job& job) {
    const WideNode<node_width>& node = view_.tree.nodes[job.place.index()];
    const unsigned any = test_all(node, job);
    reserve(job.free + static_cast<std::size_t>(std::popcount(any)) * job.count);
    const std::size_t before = jobs_.size();
    std::uint32_t free = job.free;
    for (unsigned rest = any; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      const std::uint32_t* const ids = ids_.data() + job.first;
      float nearest;
      const std::uint32_t count = Simd::template collect<node_width>(met_.data(), ids, entries_.data(), job.count, child,
                                                                     ids_.data() + free, nears_.data() + free, nearest);
      jobs_.push_back({node.children[child], free, count, 0, nearest});
      free += count;
    }
    for (std::size_t i = before; i < jobs_.size(); ++i) jobs_[i].free = free;
    std::sort(jobs_.begin() + static_cast<std::ptrdiff_t>(before), jobs_.end(),
              [](const Job& a, const Job& b) { return a.near > b.near; });
  }

  // Writes for each ray of a list which children it meets (and where it enters them); answers which are met by any.
  [[gnu::flatten]] unsigned test_all(const WideNode<node_width>& node, const Job& job) {
    if (met_.size() < job.count + 16) {
      met_.resize(2 * job.count + 16);
      entries_.resize(node_width * met_.size());
    }
    unsigned any = 0;
    for (std::uint32_t i = 0; i < job.count; ++i) {
      const Traveller& traveller = travellers_[ids_[job.first + i]];
      Boxes near;
      any |= met_[i] = NodeTest<Simd, node_width>(traveller.slab).met(node, Boxes::set(traveller.far), near);
      near.store_anywhere(entries_.data() + i * node_width);
    }
    for (std::uint32_t i = job.count; i < (job.count + 15) / 16 * 16; ++i) met_[i] = 0;
    return any;
  }

  // A leaf's rays in turn.
  [[gnu::flatten]] void test_leaf(const Job& job) {
    for (std::uint32_t i = job.first; i < job.first + job.count; ++i) {
      Traveller& traveller = travellers_[ids_[i]];
      if (nears_[i] > traveller.far) continue;
      if (!traveller.has_shear) {
        traveller.shear = TriangleRay(traveller.ray.direction);
        traveller.has_shear = true;
      }
      const LeafQuery<Simd, Pack, false, CountNothing> test(traveller.ray.origin, traveller.shear);
      CountNothing nothing;
      if (test.test(view_, traveller.ray, job.place, traveller.hit, nothing)) traveller.far = traveller.limit(traveller.hit.t);
    }
  }

  const View& view_;
  const std::span<const Ray> rays_;
  std::vector<Traveller>& travellers_;
  // Lists of rays: who they are, and where they enter the list's box.
  std::vector<std::uint32_t>& ids_;
  std::vector<float>& nears_;
  // The visit in hand has, by ray, the children met and where they are entered.
  std::vector<std::uint32_t>& met_;
  std::vector<float>& entries_;
  std::vector<Job>& jobs_;
};

}  // namespace
}  // namespace etendue
