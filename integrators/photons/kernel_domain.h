// The part of a kernel's disc that the surface covers: remedies for the loss of light at edges and its leaking through walls.
//
// A density estimate divides photons by the whole disc's area although, within r of an edge, part of the disc is off the
// surface (at distance x r from a straight edge a box kernel keeps 1 - (acos x - x sqrt(1 - x^2)) / pi, at the edge one half),
// and it counts photons behind walls. Both remedies count photons in a part D of the disc alone and divide by the kernel's
// integral over D; where D is covered by the surface, even light is estimated without bias.
//
// VisibleDomain is the part of its own surface that the point sees, found by rays: geometry-aware areas are [Hey2002]'s remedy,
// a kernel cut at visibility [Herzog2007]'s. In 16 directions a ray along the tangent plane finds walls, and probes down to the
// surface find its end, within r / 64. D is the polygon through what they reach, or the full sector where two neighbours reach
// r. A straight edge is found exactly, and light does not leak past walls on the same floor. Where every other direction
// reaches r the disc is taken to be whole, without the rest: a straight edge between two of them cuts off 1.3 % of it at most.
// Gaps in the surface nearer than the point reached are missed, and so are steps lower than r / 5; of a surface that curves
// away by more than that, D is the nearer part.
//
// PhotonHull is the convex hull of the photons themselves: no rays. Only photons strictly inside of it are counted: given the
// hull, they are uniform in it, so that their number over its area is unbiased for any convex piece of surface ([Efron1965],
// [Baldin2016]; for a kernel the same follows from Mecke's formula, with its integral over the hull for the area), at the price
// of the hull's own photons: 12 of 50. Uneven light (a caustic) has a hull of its own, brighter than it should be: not for
// caustic maps.
//
// Distances are taken along chords, directions in the tangent plane: Lambert's projection, which keeps areas on spheres.
#pragma once

#include "framework/integrator.h"
#include "integrators/photons/density_kernel.h"

#include <algorithm>
#include <array>
#include <span>

namespace etendue {

// An offset from a point, turned into its tangent plane at its own length.
inline vec2 in_tangent_plane(const Frame& frame, const vec3& offset) {
  const vec2 flat(glm::dot(offset, frame.tangent), glm::dot(offset, frame.bitangent));
  const float length = glm::length(flat);
  return length > 0 ? flat * (glm::length(offset) / length) : vec2(0);
}

class VisibleDomain {
 public:
  // `normal`: of the side that is looked at. `alone`: nothing that hides photons is within the radius, so that no rays look for
  // walls.
  VisibleDomain(const RenderContext& context, const vec3& position, const vec3& normal, float radius, bool alone = false);

  bool is_disc() const {
    return std::ranges::all_of(reach_, [this](float reach) { return reach >= radius_; });
  }
  // For offsets within the disc.
  bool contains(const vec3& offset) const;
  // The share of the kernel's integral that is covered, in (0, 1].
  float share(Kernel kernel) const;

 private:
  static constexpr int directions = 16;
  static vec2 direction(int i);
  vec2 corner(int i) const { return reach_[i % directions] * direction(i % directions); }
  bool full(int i) const { return reach_[i] >= radius_ && reach_[(i + 1) % directions] >= radius_; }

  Frame frame_;
  float radius_;
  std::array<float, directions> reach_;
};

class PhotonHull {
 public:
  // The hull of points in the tangent plane, about the origin.
  explicit PhotonHull(std::span<const vec2> points);

  // Ids of the points that are corners; all others are inside.
  std::span<const std::uint32_t> corners() const { return corners_; }
  // The share within the hull of the integral of a kernel about the origin that reaches as far as all points do.
  float share(Kernel kernel, float radius) const;

 private:
  std::span<const vec2> points_;
  std::vector<std::uint32_t> corners_;  // counter-clockwise
};

// Throws Error for a radius (metres), given and not found, beyond the scene's diagonal. A disc larger than all there is holds
// nearly no surface, and as a kernel divides by its area, the image would be black or nearly so, without a word. It is mostly a
// length in another unit that asks for this. Infinite planes have no diagonal.
void check_given_radius(const RenderContext& context, float radius);

}  // namespace etendue
