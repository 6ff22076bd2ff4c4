// Scenes in the language of pbrt, versions 3 and 4, but for participating media and motion. docs/scene-files.md lists what is
// read exactly, what loads with a warning, and what only by approximation; a test holds it against pbrt_support() of support.h.
// Names of files are relative to the file that holds them, else to the first file (scene_files.h).
//
// What would change the image and is not understood is an error, down to single parameters, unless approximations are allowed
// (approximations.h). What is left to the command line (sampling) or cannot matter is skipped, with a warning in
// Scene::warnings where a reader might wonder. RGB of lights is taken as radiance, intensity or irradiance as it stands;
// spectra of lights are scaled to luminance 1, as version 4 does.
//
// Orientation: normals given are kept and set the side of triangles that have them; else a triangle faces (p1-p0) x (p2-p0) as
// placed, turned by ReverseOrientation and by transforms that swap handedness. Quadrics face outward, disks along their axis,
// turned by ReverseOrientation alone.
#pragma once

#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <string>

namespace etendue {

// Throws Error at `file:line:col`.
Scene read_pbrt(const std::string& path, const SceneReading& reading = {});
// `path` names the text in messages and is where relative file names start from.
Scene parse_pbrt(std::string text, const std::string& path, const SceneReading& reading = {});

}  // namespace etendue
