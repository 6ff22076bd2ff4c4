// Built-in scenes whose image is known in closed form, so that no reference render is needed.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

#include <span>
#include <vector>

namespace etendue {

struct ReflectedParams {
  float albedo = 0.5f;
};

template <class Visitor>
void describe(Visitor& v, ReflectedParams& p) {
  v.number("albedo", p.albedo, 0, 0.9999, "1", "of the sphere: light is reflected 1 / (1 - albedo) times on the mean");
}

Scene make_lambert_sphere(const ReflectedParams& params);  // diffuse sphere, point light at its centre
Scene make_lambert_sphere_off_centre();                    // the same, the light off the centre
Scene make_furnace(const ReflectedParams& params);         // closed sphere, constant emission and albedo
Scene make_white_furnace();                                // lossless objects in a unit environment
Scene make_polygon_light();                                // direct light of a rectangle on a plane
Scene make_sphere_light();                                 // ... of a sphere
Scene make_disc_light();                                   // ... of a parallel disc

// Irradiance of direct light at a point with unit normal, in W/m^2 for unit radiance; the closed forms behind the scenes above
// and the tests of gradients.
double polygon_irradiance(const dvec3& point, const dvec3& normal, std::span<const dvec3> corners);  // all above the horizon
inline double polygon_irradiance(const dvec3& point, const dvec3& normal, const std::vector<dvec3>& corners) {
  return polygon_irradiance(point, normal, std::span(corners));
}
double sphere_irradiance(const dvec3& point, const dvec3& normal, const dvec3& centre, double radius);  // all above the horizon
double disc_irradiance(double distance, double offset, double radius);  // parallel disc, lateral offset of its centre

}  // namespace etendue
