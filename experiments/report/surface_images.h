// What the camera sees first in each pixel, as images for denoisers, compositing and masks. They depend on the scene and the
// camera alone, so that they are the same whatever method rendered the picture.
//
//   albedo     the share of light that arrives straight on and is reflected or let through; black where nothing is seen
//   normal     the shading normal in the world, unit, turned to the viewer; 0 where nothing is seen
//   position   in the scene file's coordinates, metres; 0 where nothing is seen
//   depth      the distance along the ray, metres, in all channels; infinity where nothing is seen
//   primitive  R its number in its object (triangles first), G its instance (0: the world's own geometry), B its object;
//              infinite planes are their number, -2 and -2; -1 where nothing is seen
//   material   its number in the scene, in all channels; -1 where nothing is seen
//
// Albedo and normal are means over 4 x 4 rays of the pixel, as denoisers want them; a mean of normals is shorter than one. The
// others are what the ray through the pixel's centre meets, for they have no mean across an edge. All rays pass through the
// middle of the lens. Numbers above 2^24 are rounded, since the files hold single precision.
#pragma once

#include "framework/image/film.h"
#include "framework/integrator.h"

#include <span>
#include <string>

namespace etendue {

std::span<const std::string> surface_image_names();
bool is_surface_image(const std::string& name);

// `name` is one of them (CHECK).
Image draw_surface_image(const std::string& name, const RenderContext& context);

}  // namespace etendue
