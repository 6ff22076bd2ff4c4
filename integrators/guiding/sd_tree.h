// A cache of incident radiance for sampling directions: the spatio-directional tree of [Mueller2017].
//
// A binary tree over space, its axes taken in turn, holds in each leaf a quadtree over directions (guided_directions.h). Paths
// of one training block are sampled from what the previous block has learnt, and recorded for the next. Between blocks, leaves
// with more records than a threshold are divided and quadtrees are refined.
//
// Deviations: there are six such trees, for the six axes that a normal (on the side the path comes from) may be nearest to; a
// leaf that held both a floor and a ceiling would waste half of its samples at each. So directions can be learnt in proportion
// to radiance times cosine, which is best for a diffuse surface. And the radiance recorded from a diffuse next surface is the
// light sample there plus the mean that such surfaces in its leaf scattered in the previous block: the cache closes the path,
// as in [Dahm2017], without the noise of all further bounces. The error of that mean within a leaf affects only the guide, not
// the image.
//
// Each leaf also learns the share of directions to sample by the BSDF, for diffuse surfaces and for others: of the candidates
// `bsdf_shares` the one with which the estimates of the previous block would have had the least second moment ([Mueller2019],
// section 10.5.3, with the variance in place of cross-entropy, whose choices trust a guide too much; there by gradient descent,
// here by a sum per candidate, which does not depend on the order of samples).
//
// Records come in spans whose order is given: they are sorted by leaf, and each leaf adds its own in that order. So trees do
// not depend on threads.
#pragma once

#include "integrators/guiding/guided_directions.h"

#include <span>

namespace etendue {

// One scattering event of a path, and what came back along the direction it chose. Luminances throughout.
struct GuideRecord {
  std::uint32_t leaf;         // that it teaches: SdTree::leaf_to_teach
  vec2 square;                // of the direction, towards where the light came from
  float cosine;               // of that direction with the normal, absolute
  float radiance;             // estimate of the light that the event's light sample did not include
  float gathered;             // the path's own estimate of it, without help from a cache
  float scattered;            // of f |cos|; 0: no direction was found
  float albedo;               // of a diffuse surface; 0 for others
  float pdf;                  // of the direction, as it was sampled
  float pdf_bsdf, pdf_guide;  // the densities mixed in `pdf`; over solid angle
};

struct SdTreeOptions {
  float split = 2000;       // records that a leaf divides at, times sqrt(samples of the block)
  float rho = 0.02f;        // share of flux that a quadrant divides at
  bool stochastic = false;  // spread records over space by a leaf's size ([Mueller2019] 10.5.2)
  bool learn_share = true;  // else bsdf_share everywhere
  float bsdf_share = 0.5f;
};

// Density of directions of which a share is taken from the BSDF, the others from the guide.
inline float mixed_pdf(float bsdf_share, float pdf_bsdf, float pdf_guide) {
  return bsdf_share * pdf_bsdf + (1 - bsdf_share) * pdf_guide;
}

inline constexpr std::array<float, 6> bsdf_shares{0.2f, 0.3f, 0.4f, 0.5f, 0.7f, 0.9f};

// The distributions to sample from at one place.
class Guide {
 public:
  // Share of directions to take from the BSDF of a diffuse surface, or of another; 1 where nothing was learnt.
  float bsdf_share(bool diffuse) const { return shares_[diffuse]; }
  const DirectionDensity& directions() const { return directions_; }
  // Indirect radiance that a diffuse surface here scatters per albedo: the mean over the previous block; < 0: not known.
  float indirect() const { return indirect_; }

 private:
  friend class SdTree;
  DirectionDensity directions_;
  std::array<float, 2> shares_{1, 1};
  float indirect_ = -1;
};

class SdTree {
 public:
  SdTree(const Bounds& bounds, const SdTreeOptions& options);

  // The leaf that holds a position. `normal`: on the side the path comes from.
  std::uint32_t leaf(const vec3& position, const vec3& normal) const { return find(position, normal).leaf; }
  // The leaf that an event which chose a direction there belongs to: the same, or with the stochastic filter one near it.
  std::uint32_t leaf_to_teach(std::uint32_t leaf, const vec3& position, const vec3& normal, const vec2& square) const;
  const Guide& guide(std::uint32_t leaf) const { return guides_[leaf]; }
  void learn(std::span<const std::vector<GuideRecord>> records);
  // Between blocks: what was learnt, in a block of so many samples per pixel, becomes what is sampled from.
  void refine(double samples);

  std::size_t leaves() const { return guides_.size(); }

 private:
  struct Node {
    std::uint32_t child = 0;  // of the lower half, the upper one follows; 0: a leaf
    std::uint32_t leaf = 0;
  };
  struct Place {
    std::uint32_t leaf;
    vec3 size;  // of the leaf
  };
  // Holds what a leaf learns in a block.
  struct Lesson {
    DirectionTree directions;
    std::array<std::array<double, bsdf_shares.size()>, 2> second_moments{};  // per candidate
    double records = 0;
    double scattered = 0, albedo = 0;  // sums for Guide::indirect_
  };
  Place find(const vec3& position, const vec3& normal) const;
  void add(Lesson& lesson, const GuideRecord& record) const;
  void split(std::size_t node, double threshold, int depth);
  void choose_share(float& share, const std::array<double, bsdf_shares.size()>& second_moments) const;
  void finish(Guide& guide, Lesson& lesson) const;

  SdTreeOptions options_;
  vec3 origin_, size_;
  std::vector<Node> nodes_;    // the first six are roots
  std::vector<Guide> guides_;  // of the leaves
  std::vector<Lesson> lessons_;
};

}  // namespace etendue
