// The rays on which structures are compared, recorded once from two renders of the scene, and how long they take.
//
// A path tracer (one sample per pixel, at most five scattering events) gives primary, diffuse and shadow rays; a photon map's
// photon pass gives photon rays, its final gathering (16 rays from each of a sixteenth of the pixels) gather rays. They run on
// one thread, so that rays have the order in which a renderer's thread traces them: paths tile by tile, event by event.
#pragma once

#include "experiments/log/values.h"
#include "framework/core/sampler.h"
#include "framework/query.h"
#include "framework/scene/scene.h"

#include <span>

namespace etendue {

using RaysByKind = ByRayKind<std::vector<Ray>>;

// About resolution^2 rays of each kind, or as many as there are; from more, runs of 64 successive rays are kept, spread evenly
// over the render. A scene without lights gets a constant environment, so that shadow and photon rays exist. The rays depend
// only on the scene, not on the `tracer`.
RaysByKind record_rays(const Scene& scene, const RayQuery& tracer, int resolution);

// Keeps at most `count` of the rays, in runs of 64 successive ones spread evenly over them.
std::vector<Ray> spread_runs(const std::vector<Ray>& rays, std::size_t count);

// Millions of rays a second on this thread: ray by ray through the interface (one indirect call a ray), or through the calls
// that take many. Shadow rays ask occluded(), others closest(). 0 where there are no rays.
double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);
double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays);

// How many of `rays`, at most all, a structure can trace within `seconds`, estimated from the first few.
std::size_t affordable_rays(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, double seconds);

// The mean over all rays of what was counted on some of each kind: a kind weighs as much as it has rays, however few of them
// were traced. 0 where none were.
double mean_over_kinds(const ByRayKind<std::uint64_t>& counted, const ByRayKind<std::size_t>& traced, const RaysByKind& rays);

// Makes a ray on from where this one hits, in a cosine-distributed direction on its side of the surface.
Ray cosine_bounce(const Scene& scene, const Ray& ray, const Hit& hit, Sampler& sampler);

}  // namespace etendue
