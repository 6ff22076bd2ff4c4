// Are a structure's answers right? Every one is held against double precision (accel/ray/exact.h), on rays that a render asked
// and on rays aimed at what breaks structures.
#pragma once

#include "accel/ray/exact.h"
#include "experiments/harness/ray_kind.h"

#include <functional>
#include <span>
#include <string>

namespace etendue {

// What double precision finds on each ray; on all threads.
std::vector<std::optional<ExactHit>> exact_hits(const ExactTracer& tracer, std::span<const Ray> rays);

// Answers that are wrong: of closest() to each ray, or of occluded(), asked ray by ray and through the calls that take many; a
// ray counts once. On all threads.
std::uint64_t wrong_hits(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                         std::span<const std::optional<ExactHit>> exact);
std::uint64_t wrong_occlusions(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                               std::span<const std::optional<ExactHit>> exact);

// The scene as it is; spanning about 1024 m, 1e6 m away along each axis; 2^20 times its size; 2^-20 times.
struct CheckFrame {
  std::string name;
  float scale = 1, offset = 0;
};
std::vector<CheckFrame> check_frames(const Scene& scene);
// Geometry alone is moved: the result serves for tracing.
Scene moved_scene(const Scene& scene, const CheckFrame& frame);

// Rays [first, first + count) of an endless sequence about a scene: of three successive ones, one is aimed at a vertex, one
// at a point of an edge, the third at a random point of the scene's box; one in six of the aimed stands upright on its target
// along an axis, one in five of all ends at 0.5 to 1.5 times the way. Ray i depends on the scene and i alone.
std::vector<Ray> aimed_rays(const Scene& scene, std::uint64_t first, std::size_t count);

}  // namespace etendue
