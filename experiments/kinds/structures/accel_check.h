// Are a structure's answers right? Each is compared with double precision (accel/exact/exact.h), on rays recorded from a render
// and on rays aimed at edges, vertices and scales that break structures.
#pragma once

#include "accel/exact/exact.h"

#include <span>
#include <string>

namespace etendue {

// The hit of each ray in double precision; runs on all threads.
std::vector<std::optional<ExactHit>> exact_hits(const ExactTracer& tracer, std::span<const Ray> rays);

// Counts wrong answers of closest(), or of occluded(), called ray by ray and for many rays at once; each ray counts once. Runs
// on all threads.
std::uint64_t wrong_hits(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                         std::span<const std::optional<ExactHit>> exact);
std::uint64_t wrong_occlusions(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                               std::span<const std::optional<ExactHit>> exact);

// Four frames: the scene as it is; about 1024 m wide and 1e6 m away along each axis; 2^20 times its size; 2^-20 times.
struct CheckFrame {
  std::string name;
  float scale = 1, offset = 0;
};
std::vector<CheckFrame> check_frames(const Scene& scene);
// Moves only the geometry: the result can be traced, not rendered.
Scene moved_scene(const Scene& scene, const CheckFrame& frame);

// Rays [first, first + count) of an endless sequence about a scene: of three successive ones, one is aimed at a vertex, one at
// a point of an edge, the third at a random point of the scene's box; one in six of the aimed rays is parallel to an axis, and
// one in five of all ends at 0.5 to 1.5 times the distance to its target. Ray i depends on the scene and i alone.
std::vector<Ray> aimed_rays(const Scene& scene, std::uint64_t first, std::size_t count);

}  // namespace etendue
