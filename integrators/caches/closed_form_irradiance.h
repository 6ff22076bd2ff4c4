// Irradiance and its derivatives at a point from the scene's closed form, where it has one: records without noise, so that a
// cache's error is only that of interpolation and of the placement of records.
//
// The closed form gives radiance; a diffuse surface of albedo rho and exitant radiance L receives E = pi L / rho. Derivatives
// are central differences over the tangent plane, along the surface: on a curved one the turn of the normal is in the
// translation gradient, and that of rotation is zero. At a border the gradient is one-sided and the Hessian 0; across a crease
// or a discontinuity both are what the differences give. The closed form holds light of all bounces: a depth limit is ignored.
#pragma once

#include "integrators/caches/records/hemisphere.h"
#include "integrators/photons/cache_points.h"

namespace etendue {

// The scene must have a closed form. Throws Error where the point's surface is not purely diffuse. Channels of albedo 0 get 0.
IrradianceEstimate closed_form_irradiance(const RenderContext& context, const CachePoint& point);

}  // namespace etendue
