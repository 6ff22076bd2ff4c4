// Which method reaches the least error with the effort stated, from what the scene needs and what a pilot found.
#pragma once

#include "framework/integrator.h"
#include "integrators/pilot/pilot.h"

namespace etendue {

enum class BiasAllowed : std::uint8_t { any, vanishing, none };
constexpr auto names_of(BiasAllowed) { return std::array{"any", "vanishing", "none"}; }

// What a budget of time counts as work: rays a second in a small scene, about what two threads trace within a method on the
// machine of results/, and seconds to build a structure, for each triangle. The choice goes by these numbers wherever it is
// made, so that it depends on scene, seed and budget alone.
inline constexpr double rays_per_second = 8e6, build_seconds = 4e-7;

// The effort in rays a pixel. A time counts as what the build leaves of it, at a pace that is halved by 15,000 triangles and
// goes on falling. Iterations count as many paths. An error counts as a tenth of the paths that would reach it, since photons
// or a cache need fewer. Of several the least counts; where nothing is stated, it is that of 64 iterations.
double rays_a_pixel(const Scene& scene, const Effort& effort, ivec2 resolution, const PilotFindings& findings);

// Before any ray is traced a path is taken to have six, or as many fewer as surfaces are sparse. A line that meets
// the scene's bounds meets as many boxes of primitives, in the mean, as these have of its surface area ([Goldsmith1987]).
inline constexpr double most_usual_rays = 6;
double usual_rays_per_path(const Scene& scene);

// The effort in rays a pixel, as far as it is known before any are traced. A time is counted in rays, whatever paths take.
double rays_before_paths(const Scene& scene, const Effort& effort, ivec2 resolution);

// A pilot that takes about a twelfth of the effort stated, and at least some 90,000 rays: of fewer it would not tell.
PilotFindings run_pilot_within_effort(const RenderContext& context);

// Says that light on what is seen comes by way of specular surfaces, where the method finds it by chance alone, if at all, and
// which method brings it; "" where it does not.
std::string caustics_out_of_reach(const RenderContext& context, const PilotFindings& findings, const std::string& method);

MethodChoice choose_method(const RenderContext& context, const PilotFindings& findings, BiasAllowed bias = BiasAllowed::any);

}  // namespace etendue
