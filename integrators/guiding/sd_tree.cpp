#include "integrators/guiding/sd_tree.h"

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
SdTree::SdTree(const Bounds& bounds, const SdTreeOptions& options) : options_(options), guides_(roots), lessons_(roots) {
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

// With the stochastic filter it is the leaf of a point drawn from a box about the position, as large as the position's own
// leaf. The point depends on the event alone.
std::uint32_t SdTree::leaf_to_teach(std::uint32_t leaf, const vec3& position, const vec3& normal, const vec2& square) const {
  if (!options_.stochastic) return leaf;
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  Pcg32 rng(hash_keys(bits(square.x), bits(square.y), bits(position.x)), hash_keys(bits(position.y), bits(position.z)));
  const float x = rng.next_float(), y = rng.next_float(), z = rng.next_float();
  return find(position + (vec3(x, y, z) - 0.5f) * find(position, normal).size, normal).leaf;
}

void SdTree::add(Lesson& lesson, const GuideRecord& record) const {
  lesson.records += 1;
  const float scattered = record.gathered * record.scattered / record.pdf;
  if (!std::isfinite(scattered)) return;  // or roulette would end all paths that come here
  lesson.albedo += record.albedo;
  if (record.albedo > 0) lesson.scattered += scattered;
  const float flux = record.radiance / record.pdf;
  if (!(flux > 0) || !std::isfinite(flux)) return;
  lesson.directions.add(record.square, flux * record.cosine);
  const bool guided = record.pdf_guide > 0 || record.pdf < record.pdf_bsdf;  // or the BSDF alone was sampled
  if (!options_.learn_share || !guided) return;
  const double product = double(flux) * record.scattered, moment = product * product * record.pdf;
  auto& moments = lesson.second_moments[record.albedo > 0];
  for (std::size_t i = 0; i < bsdf_shares.size(); ++i)
    moments[i] += moment / mixed_pdf(bsdf_shares[i], record.pdf_bsdf, record.pdf_guide);
}

void SdTree::learn(std::span<const std::vector<GuideRecord>> records) {
  // A counting sort by leaf that keeps the order.
  std::vector<std::size_t> begin(lessons_.size() + 1, 0);
  for (const auto& some : records)
    for (const GuideRecord& record : some) ++begin[record.leaf + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<const GuideRecord*> sorted(begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (const auto& some : records)
    for (const GuideRecord& record : some) sorted[next[record.leaf]++] = &record;
  parallel_for(lessons_.size(), 1, [&](std::size_t l) {
    for (std::size_t i = begin[l]; i < begin[l + 1]; ++i) {
      __builtin_prefetch(sorted[std::min(i + 8, begin[l + 1] - 1)]);
      add(lessons_[l], *sorted[i]);
    }
  });
}

// Divides a leaf until none of its parts has more records than the threshold, which are taken to be halved each time.
void SdTree::split(std::size_t node, double threshold, int depth) {
  const std::uint32_t lower = nodes_[node].leaf;
  if (lessons_[lower].records <= threshold || depth >= deepest_split) return;
  const auto child = static_cast<std::uint32_t>(nodes_.size()), upper = static_cast<std::uint32_t>(guides_.size());
  lessons_[lower].records *= 0.5;
  guides_.push_back(guides_[lower]);
  lessons_.push_back(lessons_[lower]);
  nodes_[node].child = child;
  nodes_.push_back({0, lower});
  nodes_.push_back({0, upper});
  split(child, threshold, depth + 1);
  split(child + 1, threshold, depth + 1);
}

void SdTree::choose_share(float& share, const std::array<double, bsdf_shares.size()>& second_moments) const {
  const auto best = std::min_element(second_moments.begin(), second_moments.end());
  if (share == 1 || !options_.learn_share)
    share = options_.bsdf_share;
  else if (*best != 0)
    share = bsdf_shares[static_cast<std::size_t>(best - second_moments.begin())];
}

void SdTree::finish(Guide& guide, Lesson& lesson) const {
  DirectionTree next = lesson.directions.flux() > 0 ? lesson.directions.refined(options_.rho) : lesson.directions;
  if (lesson.directions.flux() > 0) {
    for (int kind = 0; kind < 2; ++kind) choose_share(guide.shares_[kind], lesson.second_moments[kind]);
    guide.directions_ = DirectionDensity(lesson.directions);
  }
  if (lesson.albedo > 0) guide.indirect_ = static_cast<float>(lesson.scattered / lesson.albedo);
  lesson = {.directions = std::move(next)};
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
  parallel_for(guides_.size(), 16, [&](std::size_t i) { finish(guides_[i], lessons_[i]); });
}

}  // namespace etendue
