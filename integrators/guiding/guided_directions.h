// A density over directions learnt from samples: the directional quadtree of [Mueller2017], section 3.
//
// The sphere is mapped to the unit square by (cos theta, phi), which preserves area, so that a density over the square is 4 pi
// times that over solid angle. A quadrant that holds more than a share rho of the whole flux is divided, others are merged,
// down to a depth; within a leaf the density is constant. Sums are kept in every inner node; what is sampled from keeps their
// quotients instead (DirectionDensity), so that evaluating and sampling descend once, without a division. Sampling warps the
// square ([McCool1997]): stratified numbers stay stratified.
#pragma once

#include "framework/core/vec.h"

#include <array>
#include <cstdint>
#include <vector>

namespace etendue {

// Unit direction (z up) to the square [0, 1)^2 and back; area times 4 pi is solid angle.
vec2 square_from_direction(const vec3& direction);
vec3 direction_from_square(const vec2& square);

class DirectionTree {
 public:
  static constexpr int deepest = 20;

  DirectionTree() : nodes_(1) {}

  float flux() const { return sum(nodes_[0]); }
  std::size_t size() const { return nodes_.size(); }
  // Adds flux that arrives from a direction.
  void add(const vec2& square, float flux);

  // A tree without flux, subdivided where this one's flux requires it.
  DirectionTree refined(float rho) const;

 private:
  friend class DirectionDensity;
  struct Node {
    std::array<float, 4> flux{};           // of the quadrants: bit 0 is x, bit 1 is y
    std::array<std::uint16_t, 4> child{};  // 0: not divided
  };
  static float sum(const Node& node) { return (node.flux[0] + node.flux[1]) + (node.flux[2] + node.flux[3]); }

  std::vector<Node> nodes_;
};

// The density that a tree has learnt.
class DirectionDensity {
 public:
  DirectionDensity() : DirectionDensity(DirectionTree()) {}
  explicit DirectionDensity(const DirectionTree& learnt);

  // Density over the square, with mean 1. Of a tree without flux it is uniform.
  float density(const vec2& square) const;
  float pdf_solid_angle(const vec3& direction) const { return density(square_from_direction(direction)) / (4 * pi); }
  struct Sample {
    vec2 square;
    float density;  // of the node that was drawn from
  };
  Sample sample(vec2 u) const;

 private:
  // Splits a number in [0, 1): `share` of it choose the lower half, and what is left is stretched to [0, 1) by one of
  // `stretch`.
  struct Split {
    float share = 0.5f;
    std::array<float, 2> stretch{2, 2};

    Split() = default;
    Split(float low, float high);
    bool choose(float& u) const;
  };
  // A node takes less than a cache line.
  struct Node {
    Split x;
    std::array<Split, 2> y;  // within either half
    std::array<float, 4> density{1, 1, 1, 1};
    std::array<std::uint16_t, 4> child{};
  };

  std::vector<Node> nodes_;
};

}  // namespace etendue
