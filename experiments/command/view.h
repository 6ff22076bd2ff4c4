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
// pinhole's, and mirrored where the file's is; a closed form, which holds for the scene's own view, is taken away with a
// warning. Throws Error naming the option.
void set_camera(Scene& scene, const std::string& text);

// The pixels that are shown; empty: all. `crop` is what was typed: x0, x1, y0, y1 in shares of the image, or in pixels where
// one of them is above 1, rounded up as in pbrt; where nothing was, the scene file's own part counts. `needs_all` names an
// option that takes the whole image: the file's part then gives way, and a typed one is an Error, as is one that is no part.
Tile choose_window(const std::vector<double>& crop, const char* needs_all, const Scene& scene, ivec2 resolution);

}  // namespace etendue
