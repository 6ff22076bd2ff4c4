#include "integrators/sd_tree.h"

#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <bit>
#include <numeric>

namespace etendue {

namespace {

constexpr int deepest_split = 48;
constexpr std::uint32_t roots = 6;

// The axis nearest to a normal: x, y, z, then their opposites.
std::size_t main_axis(const vec3& normal) {
  const vec3 size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return static_cast<std::size_t>(normal[axis] < 0 ? axis + 3 : axis);
}

}  // namespace

// A cube about the scene, so that leaves are no slivers.
SdTree::SdTree(const Bounds& bounds, const SdTreeOptions& options) : options_(options), leaves_(roots) {
  for (std::uint32_t i = 0; i < roots; ++i) nodes_.push_back({0, i});
  const Bounds box = bounds.empty() ? Bounds{vec3(-1), vec3(1)} : bounds;
  const float edge = std::max(1.001f * max_component(box.diagonal()), 1e-6f);
  origin_ = box.centre() - 0.5f * edge;
  size_ = vec3(edge);
}

SdTree::Place SdTree::find(const vec3& position, const vec3& normal) const {
  vec3 place = glm::clamp((position - origin_) / size_, 0.0f, 1.0f), size = size_;
  std::size_t node = main_axis(normal);
  for (int axis = 0; nodes_[node].child != 0; axis = axis == 2 ? 0 : axis + 1) {
    place[axis] *= 2;
    size[axis] *= 0.5f;
    node = nodes_[node].child;
    if (place[axis] >= 1) {
      place[axis] -= 1;
      ++node;
    }
  }
  return {nodes_[node].leaf, size};
}

// With the stochastic filter a record goes to the leaf of a point drawn from a box about it, of its own leaf's size. What is
// drawn depends on the record alone.
std::uint32_t SdTree::leaf_of(const GuideRecord& record) const {
  const Place place = find(record.position, record.normal);
  if (!options_.stochastic) return place.leaf;
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  Pcg32 rng(hash_keys(bits(record.direction.x), bits(record.direction.y), bits(record.position.x)),
            hash_keys(bits(record.position.y), bits(record.position.z)));
  const float x = rng.next_float(), y = rng.next_float(), z = rng.next_float();
  return find(record.position + (vec3(x, y, z) - 0.5f) * place.size, record.normal).leaf;
}

void SdTree::add(Guide& guide, const GuideRecord& record) const {
  guide.records_ += 1;
  guide.albedo_ += record.albedo;
  if (record.albedo > 0) guide.scattered_ += record.gathered * record.scattered / record.pdf;
  const float flux = record.radiance / record.pdf;
  if (!(flux > 0) || !std::isfinite(flux)) return;
  guide.next_.add(square_from_direction(record.direction), flux * std::abs(glm::dot(record.direction, record.normal)));
  const float product = flux * record.scattered;
  if (!options_.learn_share || !(record.pdf_guide > 0) || !std::isfinite(product)) return;
  for (std::size_t i = 0; i < bsdf_shares.size(); ++i)
    guide.scores_[record.albedo > 0][i] +=
        product * std::log(bsdf_shares[i] * record.pdf_bsdf + (1 - bsdf_shares[i]) * record.pdf_guide);
}

void SdTree::learn(std::span<const std::vector<GuideRecord>> records) {
  std::vector<std::size_t> first{0};
  for (const auto& some : records) first.push_back(first.back() + some.size());
  std::vector<std::uint32_t> leaf(first.back());
  parallel_for(records.size(), 1, [&](std::size_t i) {
    for (std::size_t k = 0; k < records[i].size(); ++k) leaf[first[i] + k] = leaf_of(records[i][k]);
  });
  // A counting sort by leaf that keeps the order.
  std::vector<std::size_t> begin(leaves_.size() + 1, 0);
  for (const std::uint32_t l : leaf) ++begin[l + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<const GuideRecord*> sorted(leaf.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0, at = 0; i < records.size(); ++i)
    for (const GuideRecord& record : records[i]) sorted[next[leaf[at++]]++] = &record;
  parallel_for(leaves_.size(), 1, [&](std::size_t l) {
    for (std::size_t i = begin[l]; i < begin[l + 1]; ++i) add(leaves_[l], *sorted[i]);
  });
}

// Divides a leaf until none of its parts has more records than the threshold, which are taken to be halved each time.
void SdTree::split(std::size_t node, double threshold, int depth) {
  const std::uint32_t lower = nodes_[node].leaf;
  if (leaves_[lower].records_ <= threshold || depth >= deepest_split) return;
  const auto child = static_cast<std::uint32_t>(nodes_.size()), upper = static_cast<std::uint32_t>(leaves_.size());
  leaves_[lower].records_ *= 0.5;
  leaves_.push_back(leaves_[lower]);
  nodes_[node].child = child;
  nodes_.push_back({0, lower});
  nodes_.push_back({0, upper});
  split(child, threshold, depth + 1);
  split(child + 1, threshold, depth + 1);
}

void SdTree::choose_share(float& share, const std::array<double, bsdf_shares.size()>& scores) const {
  const auto best = std::max_element(scores.begin(), scores.end());
  if (share == 1 || !options_.learn_share)
    share = options_.bsdf_share;
  else if (*best != 0)
    share = bsdf_shares[static_cast<std::size_t>(best - scores.begin())];
}

void SdTree::finish(Guide& guide) const {
  if (guide.next_.flux() > 0) {
    for (int kind = 0; kind < 2; ++kind) choose_share(guide.shares_[kind], guide.scores_[kind]);
    DirectionTree refined = guide.next_.refined(options_.rho);
    guide.directions_ = std::move(guide.next_);
    guide.next_ = std::move(refined);
  }
  if (guide.albedo_ > 0) guide.indirect_ = static_cast<float>(guide.scattered_ / guide.albedo_);
  guide.scores_ = {};
  guide.records_ = guide.scattered_ = guide.albedo_ = 0;
}

void SdTree::refine(double samples) {
  const double threshold = options_.split * std::sqrt(samples);
  std::vector<std::pair<std::size_t, int>> found, ends;
  for (std::size_t i = 0; i < roots; ++i) found.emplace_back(i, 0);
  while (!found.empty()) {
    const auto [node, depth] = found.back();
    found.pop_back();
    if (nodes_[node].child == 0) {
      ends.emplace_back(node, depth);
    } else {
      found.emplace_back(nodes_[node].child, depth + 1);
      found.emplace_back(nodes_[node].child + 1, depth + 1);
    }
  }
  for (const auto& [node, depth] : ends) split(node, threshold, depth);
  parallel_for(leaves_.size(), 16, [&](std::size_t i) { finish(leaves_[i]); });
}

}  // namespace etendue
