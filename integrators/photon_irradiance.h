// Irradiance computed beforehand at places where photons landed, so that a gather ray looks up one value instead of k photons
// ([Christensen1999]).
//
// It is held where photons of another pass landed, on the side they came from. (A photon that holds the irradiance about itself
// answers wherever others are far: counted it makes that too bright, by 2.6 % of a wall whose light comes in through a door,
// and left out too dark. Of the map's photons those of another pass know nothing.) A look-up answers with the irradiance of the
// nearest place, or of one of the eight nearest, whose normal is within 25 degrees; where none is within the map's radius, and
// at surfaces that are not matt, the photons are asked as ever. What it adds to the map's bias is a step function for a smooth
// one, at gather rays' ends alone, where it averages out.
#pragma once

#include "integrators/photon_gather.h"

#include <optional>

namespace etendue {

class PhotonIrradiance {
 public:
  // Of a map's photons, at the places of others that are independent of them.
  PhotonIrradiance(const RenderContext& context, const PhotonMap& map, const Photons& places,
                   std::unique_ptr<PointQuery> query);

  struct Found {
    Rgb irradiance;    // W/m^2
    float resolution;  // metres: the kernel's radius, or the way to the photon that answers if that is longer
    float grain;       // area per photon, m^2
  };
  // On the side of unit `normal`.
  std::optional<Found> at(const vec3& position, const vec3& normal) const;
  // Most events that photons have behind them: less are asked for nowhere but under a depth limit.
  int longest() const { return longest_; }

 private:
  std::unique_ptr<PointQuery> query_;
  std::vector<vec3> position_, normal_;
  std::vector<Rgb> irradiance_;
  std::vector<float> radius_, grain_;
  float reach_;
  int longest_ = 0;
};

}  // namespace etendue
