// The rays on which structures are compared, recorded once from two renders of the scene.
//
// A path tracer (one sample per pixel, at most five scattering events) gives primary, diffuse and shadow rays; a photon map's
// photon pass gives photon rays, its final gathering (16 rays from each of a sixteenth of the pixels) gather rays. They run on
// one thread, so that rays have the order in which a renderer's thread traces them: paths tile by tile, event by event.
#pragma once

#include "experiments/log/ray_kind.h"
#include "framework/core/sampler.h"
#include "framework/scene/scene.h"

namespace etendue {

using RaysByKind = ByRayKind<std::vector<Ray>>;

// About resolution^2 rays of each kind, or as many as there are; from more, runs of 64 successive rays are kept, spread evenly
// over the render. A scene without lights gets a constant environment, so that shadow and photon rays exist. The rays depend
// only on the scene, not on the `tracer`.
RaysByKind record_rays(const Scene& scene, const RayQuery& tracer, int resolution);

// At most `count` of the rays, in runs of 64 successive ones spread evenly over them.
std::vector<Ray> spread_runs(const std::vector<Ray>& rays, std::size_t count);

// A ray on from where this one hits, in a cosine-distributed direction on its side of the surface.
Ray cosine_bounce(const Scene& scene, const Ray& ray, const Hit& hit, Sampler& sampler);

}  // namespace etendue
