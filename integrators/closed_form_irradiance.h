// Irradiance and its derivatives at a point from the scene's closed form, where it has one: records without noise, so that what
// is left of a cache's error is that of interpolation and of where records lie.
//
// The closed form is of radiance; a diffuse surface of albedo rho that leaves L receives E = pi L / rho. Derivatives are
// central differences over the tangent plane, along the surface: on a curved one the turn of the normal is in the translation
// gradient, and that of rotation is zero. At a border the gradient is one-sided and the Hessian 0, and across a crease or a
// discontinuity they are those of the difference. The closed form is of light of all orders: a limit of depth is not obeyed.
#pragma once

#include "integrators/cache_points.h"
#include "integrators/hemisphere.h"

namespace etendue {

// Of a scene that has a closed form. Throws Error where the point's surface is not purely diffuse; channels of albedo 0 get 0.
IrradianceEstimate closed_form_irradiance(const RenderContext& context, const CachePoint& point);

}  // namespace etendue
