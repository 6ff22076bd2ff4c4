#include "accel/points/nanoflann_tree.h"

#include <nanoflann.hpp>

namespace etendue {

static_assert(PointStructure<NanoflannTree>);

namespace {

struct Points {
  std::span<const vec3> points;
  std::vector<std::uint32_t> finite = {};  // their ids, where some are not; else empty

  std::uint32_t id(std::size_t i) const { return finite.empty() ? static_cast<std::uint32_t>(i) : finite[i]; }
  std::size_t kdtree_get_point_count() const { return finite.empty() ? points.size() : finite.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return (&points[id(i)].x)[axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// A limit that exceeds a squared distance by more than pruning can err: 1.5 epsilon per level of the tree, and underflow.
float search_limit(float distance_squared) { return distance_squared * 1.0001f + std::numeric_limits<float>::min(); }

// All points within a radius, as nanoflann hands them in.
class WithinResult {
 public:
  WithinResult(const Points& points, float r, Neighbours& out)
      : points_(points), limit_(r * r), search_limit_(search_limit(limit_)), out_(out) {}
  float worstDist() const { return search_limit_; }
  bool full() const { return true; }
  bool addPoint(float d2, std::uint32_t i) {
    if (d2 <= limit_) out_.push_back({points_.id(i), d2});
    return true;
  }

 private:
  const Points& points_;
  float limit_, search_limit_;
  Neighbours& out_;
};

class NearestResult {
 public:
  NearestResult(const Points& points, std::size_t k, float r_max, Neighbours& out)
      : points_(points), found_(k, r_max * r_max, out) {}
  float worstDist() const { return search_limit(found_.worst()); }
  bool full() const { return found_.full(); }
  bool addPoint(float d2, std::uint32_t i) {
    found_.add(points_.id(i), d2);
    return true;
  }
  void sort() { found_.sort(); }

 private:
  const Points& points_;
  NearestSoFar found_;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, std::uint32_t>;

constexpr std::size_t leaf_size = 10;

Points finite_points(std::span<const vec3> points) {
  Points result{points};
  if (std::all_of(points.begin(), points.end(), is_finite)) return result;
  for (std::uint32_t id = 0; id < points.size(); ++id)
    if (is_finite(points[id])) result.finite.push_back(id);
  if (result.finite.empty()) result.points = {};
  return result;
}

}  // namespace

struct NanoflannTree::Index {
  Points points;
  Tree tree;  // refers to `points`

  explicit Index(Points p) : points(std::move(p)), tree(3, points, {leaf_size}) {}
};

NanoflannTree::NanoflannTree() = default;
NanoflannTree::~NanoflannTree() = default;
NanoflannTree::NanoflannTree(NanoflannTree&&) noexcept = default;
NanoflannTree& NanoflannTree::operator=(NanoflannTree&&) noexcept = default;

void NanoflannTree::build(std::span<const vec3> points) {
  Points finite = finite_points(points);
  index_ = finite.points.empty() ? nullptr : std::make_unique<Index>(std::move(finite));
}

void NanoflannTree::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (!index_ || !can_find(p, r)) return;
  WithinResult result(index_->points, r, out);
  index_->tree.findNeighbors(result, &p.x, nanoflann::SearchParams());
}

void NanoflannTree::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (!index_ || k == 0 || !can_find(p, r_max)) return;
  NearestResult result(index_->points, k, r_max, out);
  index_->tree.findNeighbors(result, &p.x, nanoflann::SearchParams());
  result.sort();
}

std::uint64_t NanoflannTree::bytes() const {
  return index_ ? sizeof(Index) + index_->tree.usedMemory(index_->tree) + index_->points.finite.capacity() * 4 : 0;
}

}  // namespace etendue
