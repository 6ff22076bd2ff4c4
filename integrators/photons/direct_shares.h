// The number of camera paths that a pixel takes for emission and direct light, where photons bring the rest.
//
// Samples of direct light are those that choose_direct (integrators/paths/path_choices.h) finds fit.
//
// A pixel on the outline of a lamp, or of its image in glass, is bright by chance: a path meets the lamp or does not, and that
// scatters more than the photons do, of which a kernel holds dozens. Paths that gather nothing cost little. So a pixel takes
// further ones in proportion to the relative standard deviation of what one finds, with which the variance left for their
// number is least, and an iteration's emission and direct light are the mean of all. A pilot finds deviations with random
// numbers of its own: what is averaged has no part in the choice, which adds no bias ([Kirk1991] shows that else it does).
#pragma once

#include "integrators/paths/path.h"
#include "integrators/photons/photon_camera_path.h"

#include <optional>
#include <vector>

namespace etendue {

class DirectShares {
 public:
  // Each pixel takes its own path alone.
  DirectShares() = default;
  // `further`: paths, per relative standard deviation. `direct`: light samples at rough vertices, or emission alone.
  DirectShares(const PhotonCameraPath& walk, SamplerKind sampler, float further, bool direct);

  // What all_direct_light (integrators/paths/emission.h) goes by.
  MisMode mode() const { return direct_.value_or(MisMode::light); }
  // The weight of what a pixel's own camera path finds.
  float share(std::size_t pixel) const { return 1 / (1 + static_cast<float>(count(pixel))); }
  // The radiance that the further paths of a pixel find in this iteration, times their share.
  Rgb further(const PhotonCameraPath& walk, ivec2 pixel, std::uint32_t iteration) const;

 private:
  std::uint32_t count(std::size_t pixel) const { return further_.empty() ? 0 : further_[pixel]; }

  SamplerKind sampler_ = SamplerKind::sobol;
  std::optional<MisMode> direct_ = MisMode::light;  // empty: emission alone
  std::vector<std::uint8_t> further_;               // by pixel; empty: none
};

template <class Visitor>
void describe_further_paths(Visitor& v, float& further_paths) {
  v.number("further_paths", further_paths, 0, 1000, "camera paths",
           "of a pixel for emission and direct light in an iteration, per relative standard deviation of these; at most 7");
}

}  // namespace etendue
