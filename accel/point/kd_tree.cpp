#include "accel/point/kd_tree.h"

#include <nanoflann.hpp>

namespace etendue {

static_assert(PointStructure<KdTree>);

namespace {

struct Points {
  std::span<const vec3> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return (&points[i].x)[axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// Above a squared distance by more than pruning can err: 1.5 epsilon per level of the tree, and underflow.
float search_limit(float distance_squared) { return distance_squared * 1.0001f + std::numeric_limits<float>::min(); }

// All points within a radius, as nanoflann hands them in.
class WithinResult {
 public:
  WithinResult(float r, Neighbours& out) : limit_(r * r), search_limit_(search_limit(limit_)), out_(out) {}
  float worstDist() const { return search_limit_; }
  bool full() const { return true; }
  bool addPoint(float d2, std::uint32_t id) {
    if (d2 <= limit_) out_.push_back({id, d2});
    return true;
  }

 private:
  float limit_, search_limit_;
  Neighbours& out_;
};

// The k nearest within a radius: a heap with the farthest on top.
class NearestResult {
 public:
  NearestResult(std::size_t k, float r_max, Neighbours& out) : k_(k), limit_(r_max * r_max), out_(out) {}
  float worstDist() const { return search_limit(full() ? out_.front().distance_squared : limit_); }
  bool full() const { return out_.size() == k_; }
  bool addPoint(float d2, std::uint32_t id) {
    const Neighbour found{id, d2};
    if (!(d2 <= limit_) || (full() && !is_nearer(found, out_.front()))) return true;
    if (full()) {
      std::pop_heap(out_.begin(), out_.end(), is_nearer);
      out_.pop_back();
    }
    out_.push_back(found);
    std::push_heap(out_.begin(), out_.end(), is_nearer);
    return true;
  }

 private:
  std::size_t k_;
  float limit_;
  Neighbours& out_;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, std::uint32_t>;

constexpr std::size_t leaf_size = 10;

}  // namespace

struct KdTree::Index {
  Points points;
  Tree tree;  // refers to `points`

  explicit Index(std::span<const vec3> p) : points{p}, tree(3, points, {leaf_size}) {}
};

KdTree::KdTree() = default;
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

void KdTree::build(std::span<const vec3> points) { index_ = points.empty() ? nullptr : std::make_unique<Index>(points); }

void KdTree::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (!index_ || !can_find(p, r)) return;
  WithinResult result(r, out);
  index_->tree.findNeighbors(result, &p.x, nanoflann::SearchParams());
}

void KdTree::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (!index_ || k == 0 || !can_find(p, r_max)) return;
  NearestResult result(k, r_max, out);
  index_->tree.findNeighbors(result, &p.x, nanoflann::SearchParams());
  std::sort_heap(out.begin(), out.end(), is_nearer);
}

std::uint64_t KdTree::bytes() const { return index_ ? sizeof(Index) + index_->tree.usedMemory(index_->tree) : 0; }

}  // namespace etendue
