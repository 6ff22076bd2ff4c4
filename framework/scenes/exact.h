// Closed forms of irradiance, behind the built-in scenes whose image is known and the tests of gradients.
#pragma once

#include "framework/core/vec.h"

#include <span>
#include <vector>

namespace etendue {

// Irradiance of direct light at a point with unit normal, in W/m^2 for unit radiance.
double polygon_irradiance(const dvec3& point, const dvec3& normal, std::span<const dvec3> corners);  // all above the horizon
inline double polygon_irradiance(const dvec3& point, const dvec3& normal, const std::vector<dvec3>& corners) {
  return polygon_irradiance(point, normal, std::span(corners));
}
double sphere_irradiance(const dvec3& point, const dvec3& normal, const dvec3& centre, double radius);  // all above the horizon
double disc_irradiance(double distance, double offset, double radius);  // parallel disc, lateral offset of its centre

// Irradiance on the floor at horizontal distance x from a point light of 1 W/sr, `height` above a flat surface with index eta
// below it, `depth` above the floor.
double refracted_irradiance(double x, double height, double depth, double eta);

}  // namespace etendue
