#include "accel/spatial/kd_tree.h"

#include "accel/kernels/clipped_polygon.h"
#include "accel/plain_entry.h"
#include "framework/core/elementary.h"

#include <optional>

namespace etendue {

static_assert(RayStructure<RayKdTree>);

namespace {

constexpr std::size_t most_swept = 256;  // primitives of a node in which every face is tried
constexpr double empty_side_factor = 0.8;

// Areas of float coordinates can exceed the range of float.
double half_area(const Bounds& b) {
  const dvec3 d = dvec3(b.upper) - dvec3(b.lower);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

struct Reference {
  Bounds bounds;  // of what is left of the primitive within the node, enlarged by the slack
  std::uint32_t id;

  bool reaches_left(int axis, float plane) const { return bounds.lower[axis] < plane || !reaches_right(axis, plane); }
  bool reaches_right(int axis, float plane) const { return bounds.upper[axis] > plane; }
};

struct Plane {
  double cost = std::numeric_limits<double>::infinity();
  int axis = 0;
  float position = 0;
};

// The costs of cutting one node.
class Chooser {
 public:
  Chooser(const Bounds& cell, std::size_t count, double primitive_cost)
      : cell_(cell), count_(static_cast<double>(count)), primitive_cost_(primitive_cost), reciprocal_(1 / half_area(cell)) {}

  // The cheapest plane among those between `bins` equal bins of each axis.
  Plane try_bins(const std::vector<Reference>& references, int bins) {
    Plane best;
    const auto size = static_cast<std::size_t>(bins);
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = cell_.lower[axis], extent = cell_.upper[axis] - lower, scale = bins / extent;
      starts_.assign(size, 0);
      ends_.assign(size, 0);
      const auto bin = [&](double x) { return static_cast<std::size_t>(std::clamp((x - lower) * scale, 0.0, bins - 1.0)); };
      if (!(extent > 0)) continue;
      for (const Reference& r : references) {
        ++starts_[bin(r.bounds.lower[axis])];
        ++ends_[bin(r.bounds.upper[axis])];
      }
      double left = 0, right = count_;
      for (std::size_t i = 1; i < size; ++i) {
        left += starts_[i - 1];
        right -= ends_[i - 1];
        offer(best, axis, static_cast<float>(lower + extent * static_cast<double>(i) / bins), left, right);
      }
    }
    return best;
  }

  // The cheapest among all faces of the references' boxes.
  Plane try_faces(const std::vector<Reference>& references) {
    Plane best;
    for (int axis = 0; axis < 3; ++axis) {
      lowers_.clear();
      uppers_.clear();
      for (const Reference& r : references) {
        lowers_.push_back(r.bounds.lower[axis]);
        uppers_.push_back(r.bounds.upper[axis]);
      }
      std::sort(lowers_.begin(), lowers_.end());
      std::sort(uppers_.begin(), uppers_.end());
      std::size_t lower = 0, upper = 0;  // those below the plane, and those at or below it
      while (upper < uppers_.size()) {
        const float plane = lower < lowers_.size() ? std::min(lowers_[lower], uppers_[upper]) : uppers_[upper];
        while (upper < uppers_.size() && uppers_[upper] <= plane) ++upper;
        offer(best, axis, plane, static_cast<double>(lower), count_ - static_cast<double>(upper));
        while (lower < lowers_.size() && lowers_[lower] <= plane) ++lower;
      }
    }
    return best;
  }

 private:
  void offer(Plane& best, int axis, float position, double left, double right) const {
    if (!(position > cell_.lower[axis] && position < cell_.upper[axis])) return;
    Bounds low = cell_, high = cell_;
    low.upper[axis] = high.lower[axis] = position;
    double cost = 1 + primitive_cost_ * (half_area(low) * left + half_area(high) * right) * reciprocal_;
    if (left == 0 || right == 0) cost *= empty_side_factor;
    if (cost < best.cost) best = {cost, axis, position};
  }

  const Bounds& cell_;
  const double count_, primitive_cost_, reciprocal_;
  std::vector<std::uint32_t> starts_, ends_;
  std::vector<float> lowers_, uppers_;
};

}  // namespace

// Builds depth first, from a list of nodes to come instead of by recursion.
class RayKdTree::Builder {
 public:
  Builder(const Geometry& geometry, const KdTreeParams& params, RayKdTree& tree)
      : geometry_(geometry), params_(params), tree_(tree) {}

  void build() {
    Bounds bounds;
    Job root;
    for (const std::uint32_t id : geometry_.valid_primitives()) {
      root.references.push_back({geometry_.primitive_bounds(id), id});
      bounds.extend(root.references.back().bounds);
    }
    const std::size_t count = root.references.size();
    if (count == 0) return;
    slack_ = cell_slack(bounds);
    for (Reference& r : root.references) r.bounds = grown(r.bounds, slack_);
    root.cell = tree_.bounds_ = grown(bounds, slack_);
    references_ = count;
    budget_ = std::min<std::uint64_t>(references_per_primitive * count + 1024, (1u << 30) - 1);
    max_depth_ = params_.max_depth > 0 ? static_cast<std::uint32_t>(params_.max_depth)
                                       : static_cast<std::uint32_t>(8 + 1.3 * math::log2(static_cast<double>(count)));
    tree_.nodes_.resize(1);
    std::vector<Job> jobs;
    jobs.push_back(std::move(root));
    while (!jobs.empty()) {
      Job job = std::move(jobs.back());
      jobs.pop_back();
      add(job, jobs);
    }
    tree_.nodes_.shrink_to_fit();
    tree_.references_.shrink_to_fit();
    tree_.sah_cost_ /= half_area(tree_.bounds_);
    if (!std::isfinite(tree_.sah_cost_)) tree_.sah_cost_ = 0;
  }

 private:
  struct Job {
    std::uint32_t node = 0, depth = 0;
    Bounds cell;
    std::vector<Reference> references;
  };

  void add(Job& job, std::vector<Job>& jobs) {
    tree_.depth_ = std::max(tree_.depth_, job.depth);
    const std::optional<Plane> plane = job.depth < max_depth_ ? choose(job) : std::nullopt;
    if (!plane) {
      make_leaf(job);
      return;
    }
    if (params_.watch != nullptr) params_.watch->check(bytes());
    tree_.sah_cost_ += half_area(job.cell);
    const auto children = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_[job.node] = Node::inner(plane->axis, plane->position, children);
    tree_.nodes_.resize(children + 2);
    Job left{children, job.depth + 1, job.cell, {}}, right{children + 1, job.depth + 1, job.cell, {}};
    left.cell.upper[plane->axis] = right.cell.lower[plane->axis] = plane->position;
    divide(job, *plane, left, right);
    jobs.push_back(std::move(right));
    jobs.push_back(std::move(left));
  }

  // All that is held: lists that grow by doubling.
  std::uint64_t bytes() const {
    const std::uint64_t listed = tree_.references_.size();
    return 2 *
           ((references_ - listed) * sizeof(Reference) + listed * sizeof(std::uint32_t) + tree_.nodes_.size() * sizeof(Node));
  }

  void make_leaf(const Job& job) {
    tree_.sah_cost_ += half_area(job.cell) * static_cast<double>(job.references.size());
    tree_.nodes_[job.node] =
        Node::leaf(static_cast<std::uint32_t>(tree_.references_.size()), static_cast<std::uint32_t>(job.references.size()));
    for (const Reference& r : job.references) tree_.references_.push_back(r.id);
  }

  std::optional<Plane> choose(const Job& job) {
    const std::size_t count = job.references.size();
    if (count == 0) return std::nullopt;
    Chooser chooser(job.cell, count, params_.primitive_cost);
    const Plane plane = count > most_swept ? chooser.try_bins(job.references, params_.bins) : chooser.try_faces(job.references);
    if (!(plane.cost < params_.primitive_cost * static_cast<double>(count))) return std::nullopt;
    std::uint64_t both = 0;
    for (const Reference& r : job.references)
      both += r.reaches_left(plane.axis, plane.position) && r.reaches_right(plane.axis, plane.position);
    if (references_ + both > budget_) return std::nullopt;
    return plane;
  }

  void divide(Job& job, const Plane& plane, Job& left, Job& right) {
    for (const Reference& r : job.references) {
      const bool is_left = r.reaches_left(plane.axis, plane.position), is_right = r.reaches_right(plane.axis, plane.position);
      if (is_left && is_right) {
        add_clipped(r, left);
        add_clipped(r, right);
      } else {
        (is_left ? left : right).references.push_back(r);
      }
    }
    references_ += left.references.size() + right.references.size();
    references_ -= job.references.size();
    job.references = {};
  }

  // Adds the part of the primitive within the (enlarged) cell, if there is any. Of a quadric the box is cut, of a triangle the
  // triangle itself.
  void add_clipped(const Reference& reference, Job& job) const {
    Reference clipped = reference;
    if (geometry_.is_triangle(reference.id)) {
      const uvec3 v = geometry_.triangles[reference.id];
      const auto& p = geometry_.positions;
      ClippedPolygon polygon(p[v.x], p[v.y], p[v.z]);
      for (int axis = 0; axis < 3 && !polygon.empty(); ++axis)
        polygon.clip(axis, job.cell.lower[axis] - slack_, job.cell.upper[axis] + slack_);
      if (polygon.empty()) return;
      for (int axis = 0; axis < 3; ++axis) {
        const dvec2 extent = polygon.extent(axis);
        clipped.bounds.lower[axis] = std::max(clipped.bounds.lower[axis], static_cast<float>(extent.x - slack_));
        clipped.bounds.upper[axis] = std::min(clipped.bounds.upper[axis], static_cast<float>(extent.y + slack_));
      }
    }
    clipped.bounds.lower = glm::max(clipped.bounds.lower, job.cell.lower);
    clipped.bounds.upper = glm::min(clipped.bounds.upper, job.cell.upper);
    job.references.push_back(clipped);
  }

  const Geometry& geometry_;
  const KdTreeParams params_;
  RayKdTree& tree_;
  double slack_ = 0;
  std::uint64_t references_ = 0, budget_ = 0;  // in all leaves and jobs so far
  std::uint32_t max_depth_ = 0;
};

RayKdTree::RayKdTree(const Geometry& geometry, const KdTreeParams& params) : geometry_(&geometry) {
  Builder(geometry, params, *this).build();
}

RayStructureStats RayKdTree::stats() const {
  return {nodes_.size() * sizeof(Node) + references_.size() * sizeof(std::uint32_t), nodes_.size(), depth_, references_.size(),
          sah_cost_};
}

RayEntry kd_tree_entry() {
  return cells_entry<RayKdTree, KdTreeParams>(
      "kd-tree", "space cut in two by surface area, triangles clipped",
      [](const Geometry& geometry, const KdTreeParams&) { return kd_tree_need(geometry); });
}

}  // namespace etendue
