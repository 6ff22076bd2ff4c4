// Irradiance computed beforehand at photons, so that a gather ray looks up one value instead of k photons ([Christensen1999]).
//
// Every n-th photon of a map holds the irradiance about it, on the side it came from, itself included: the photon that is
// nearest to a place has more empty room about it than others, by as much as one photon fills, so that leaving it out would be
// too dark. A look-up answers with the irradiance of the nearest one, or of one of the eight nearest, whose normal is within 25
// degrees; where none is within the map's radius, and at surfaces that are not matt, the photons are asked as ever. What it
// adds to the map's bias is a step function for a smooth one, at gather rays' ends alone, where it averages out.
#pragma once

#include "integrators/photon_gather.h"

#include <optional>

namespace etendue {

class PhotonIrradiance {
 public:
  PhotonIrradiance(const RenderContext& context, const PhotonMap& map, int every, std::unique_ptr<PointQuery> query);

  struct Found {
    Rgb irradiance;    // W/m^2
    float resolution;  // metres: the kernel's radius, or the way to the photon that answers if that is longer
  };
  // On the side of unit `normal`.
  std::optional<Found> at(const vec3& position, const vec3& normal) const;
  // Most events that photons have behind them: less are asked for nowhere but under a depth limit.
  int longest() const { return longest_; }

 private:
  std::unique_ptr<PointQuery> query_;
  std::vector<vec3> position_, normal_;
  std::vector<Rgb> irradiance_;
  std::vector<float> radius_;
  float reach_;
  int longest_ = 0;
};

}  // namespace etendue
