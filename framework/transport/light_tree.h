// A tree over the lights of a scene, by which a point chooses one of them in proportion to what it may send there
// ([Estevez2018]; as in [Pharr2023] section 12.6).
//
// Each node bounds its lights: a sphere about their box, a cone about the directions that they face, the angle beyond that in
// which they emit, and the sum of their intensities. A point takes one child after another in proportion to
//
//     importance = intensity * cos(theta') / max(d, r / 2)^2,   theta' = max(0, theta_w - theta_o - theta_b)
//
// with d the distance to the sphere's centre, r its radius, theta_w the angle between the cone's axis and the point, theta_o
// the cone's half angle and theta_b the half angle under which the point sees the sphere. It is 0 where theta' is beyond the
// angle of emission: no light of the node can reach the point. The bounds are slack by more than rounding errors, so that no
// light that could send anything is ever left out. The probability of a light at a point is worked out along its way from the
// root (its bit trail), by the same arithmetic as choosing it.
//
// Deviations: the distance is at least half the radius, not the radius, since points within a node lie nearer to its lights
// than the radius says. What the illuminated surface faces does not count, so that MIS knows a light's probability where a path
// hits it from the point before alone; samples that go behind the surface are lost. No sum of several lights is taken at once
// (the paper's splitting).
#pragma once

#include "framework/query.h"

#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

class LightTree {
 public:
  // A light at a finite place: where it is, what it faces and how far beyond that it emits.
  struct Emitter {
    Bounds bounds;
    vec3 axis{0, 0, 1};         // unit
    float theta_normals = pi;   // half angle of the cone about the axis that holds its normals
    float theta_emission = pi;  // beyond a normal: pi / 2 of a surface
    float intensity = 0;        // W/sr at most, luminance; the tree never chooses a light of none
    bool two_sided = false;
  };
  struct Chosen {
    std::uint32_t light;
    double probability;  // 0: no light can send anything to the point
  };

  LightTree() = default;  // of no lights
  explicit LightTree(std::span<const Emitter> lights);

  bool empty() const { return nodes_.empty(); }
  // Chooses by u in [0, 1), which is rescaled to [0, 1) within the choice.
  Chosen choose(const vec3& position, double& u) const;
  // The probability with which `choose` takes this light.
  double probability(const vec3& position, std::uint32_t light) const;

 private:
  static constexpr int width = 4;
  // Up to four children, each property of all four beside each other, so that they are weighted together; missing ones have the
  // intensity 0.
  struct alignas(64) Node {
    float x[width]{}, y[width]{}, z[width]{};  // centre, metres
    float radius[width]{};                     // of a sphere about all lights
    float axis_x[width]{}, axis_y[width]{}, axis_z[width]{};
    float cos_normals[width]{}, sin_normals[width]{};
    float least_cosine[width]{};   // of theta' at which anything is emitted
    float intensity[width]{};      // share of all lights'
    float two_sided[width]{};      // 0 or 1
    std::uint32_t child[width]{};  // a node, or the light of a leaf with the highest bit set
  };
  struct Weights {
    float each[width];
    double sum;
  };
  class Builder;

  static Weights importance(const Node& node, const vec3& position);

  std::vector<Node> nodes_;            // the root first
  std::vector<std::uint64_t> trails_;  // per light, from the root: which child holds it, in two bits
};

}  // namespace etendue
