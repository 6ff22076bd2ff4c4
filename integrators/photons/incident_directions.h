// The directions that indirect light comes from, estimated from the photons around a point: a density for gather rays
// ([Jensen1995]).
//
// The hemisphere is mapped to the unit square by the inverse of the concentric map, so that uniform light has a uniform density
// there. Each of the nearest photons adds the light that the point reflects of it to an 8 x 8 grid, over a square two cells
// wide. Photons of histories that gather rays do not look for (direct, caustic) are left out. The density is zero in cells
// without a photon, so it must be mixed with the BSDF's.
#pragma once

#include "integrators/photons/photon_gather.h"

#include <array>

namespace etendue {

class IncidentDirections {
 public:
  // From the k nearest photons that count at the point.
  IncidentDirections(const PhotonMap& map, const GatherPoint& at, int k);

  bool empty() const { return !(total_ > 0); }
  // A unit direction on the side of the point's normal.
  vec3 sample(vec2 u) const;
  float pdf_solid_angle(const vec3& wi) const;

 private:
  static constexpr int side = 8;

  Frame frame_;
  std::array<float, side * side> weight_{};
  float total_ = 0;
};

}  // namespace etendue
