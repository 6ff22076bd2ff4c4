// What of a scene `etendue render` shows, where it is not what the file says: another camera, or a part of the image.
#pragma once

#include "framework/core/parallel.h"
#include "framework/image/film.h"
#include "framework/scene/scene.h"

#include <string>
#include <vector>

namespace etendue {

// Gives the scene another camera: one of the file's by its name, which brings its resolution, or "EYE TARGET [UP] [FOV]" with
// points as x,y,z in the file's coordinates and degrees across the shorter side of the image. A view that is typed is a
// pinhole's, and mirrored where the file's is. Throws Error naming the option.
void set_camera(Scene& scene, const std::string& text);

// The pixels of a part of the image: x0, x1, y0, y1 in shares of it, or in pixels where one of them is above 1. Rounded up, as
// in pbrt. Throws Error naming the option where it is no part.
Tile window_option(const std::vector<double>& bounds, ivec2 resolution);
// Of what a scene file states; empty (all) where that is nothing.
Tile window_of(const Scene& scene, ivec2 resolution);

}  // namespace etendue
