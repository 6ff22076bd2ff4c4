// Irradiance computed once at each of many sample points where photons landed, so that a gather ray looks up one value instead
// of k photons ([Christensen1999]); computed when a ray first asks for it, since small images and sparse records never ask for
// most of them.
//
// The sample points are where photons of another pass landed, on the side they came from. (Photons of the map itself would not
// do: each would answer where others are far, and the irradiance there is too bright if that photon is counted, by 2.6 % on a
// wall lit through a door, and too dark if it is not. Photons of another pass are independent of the map.) A look-up answers
// with the irradiance of the nearest sample point, or of one of the eight nearest, whose normal is within 25 degrees and which
// no wall hides (integrators/photons/wall_grid.h) and that reaches so far; where there is none, and at surfaces that are not
// diffuse, the photons themselves are gathered. It adds the bias of a step function in place of a smooth one, only at the ends
// of gather rays, where it averages out.
//
// Sample points lie densest where light is brightest, so that beside a bright place its points are the nearest ones for much of
// the dark. Rooms with a patch of sun were 3 to 7 % too bright by that. So each point reaches no farther than its own kernel,
// which is small where light is bright, and half as far where photons lie unevenly in it. What remains falls with the radius:
// 0.4 % of such a room with 50,000 photons, 1.3 % of another with 20,000. Of sixteen photons for each point and kernels over
// fifty, one look-up in 23 finds none in even light; of more photons for each point than kernels have, most find none.
#pragma once

#include "integrators/photons/photon_gather.h"

#include <atomic>
#include <memory>
#include <optional>

namespace etendue {

class PhotonIrradiance {
 public:
  // Estimates a map's irradiance at `sample_points`, photons that are independent of the map's.
  PhotonIrradiance(const PhotonMap& map, const Photons& sample_points, std::unique_ptr<PointQuery> query);

  struct Found {
    Rgb irradiance;          // W/m^2
    float resolution;        // metres: the kernel's radius, or the distance to the sample point that answers if that is longer
    float photon_footprint;  // area per photon, m^2
  };
  // On the side of unit `normal`, to which rays leave from `origin`.
  std::optional<Found> at(const RenderContext& context, const vec3& position, const vec3& normal, const vec3& origin) const;
  // Largest number of events before a photon landed.
  int longest() const { return longest_; }

 private:
  enum State : std::uint8_t { unknown, under_way, known };

  // How far a sample point answers whose kernel has that radius, in metres.
  float reach(const GatherPoint& at, float radius) const;
  // The estimate by the photons about a sample point. Computes it, and how far it answers, if no thread has.
  const PhotonMap::Estimate& estimate(const RenderContext& context, std::uint32_t id) const;

  std::unique_ptr<PointQuery> query_;
  const PhotonMap& map_;
  std::vector<vec3> position_, normal_, direction_;
  std::vector<float> flown_;
  mutable std::vector<PhotonMap::Estimate> estimate_;
  mutable std::vector<float> reach_;
  mutable std::unique_ptr<std::atomic<State>[]> state_;  // of each estimate
  int longest_ = 0;
};

}  // namespace etendue
