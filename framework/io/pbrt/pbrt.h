// Scenes in the language of pbrt: a subset of version 4, with version 3's names beside it.
//
//   transforms   all of them, at one time; CoordinateSystem, CoordSysTransform, TransformBegin/End, AttributeBegin/End
//   files        Include, Import; names are relative to the file that holds them, else to the first file (scene_files.h)
//   camera       perspective; film image or rgb; PixelFilter, Sampler, Integrator (maxdepth alone is kept), Accelerator
//   shapes       trianglemesh, plymesh; whole spheres, cylinders and disks; ObjectBegin/End, ObjectInstance
//   materials    diffuse/matte, mirror, conductor/metal, dielectric/glass, coateddiffuse/plastic; named ones
//   textures     constant, imagemap, checkerboard, scale, mix: images and checkerboards for reflectances, constants elsewhere
//   lights       area lights on shapes; point, spot, distant, infinite (constant, or an image: octahedral by version 4's
//                `filename`, equirectangular by version 3's `mapname`)
//
// What would change the image and is not understood is an error, down to single parameters; what is left to the command line
// (sampling) or cannot matter is skipped, with a warning in Scene::warnings where a reader might wonder. RGB of lights is taken
// as radiance, intensity or irradiance as it stands; spectra of lights are scaled to luminance 1, as version 4 does.
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
