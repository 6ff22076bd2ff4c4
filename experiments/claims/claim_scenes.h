// Scenes of the make that the claims' sources had, beside the built-in ones: "claim:NAME?key=value,…".
//
//   spheres    a floor, a light and `count` spheres of unequal size strewn over it: few triangles, many spheres
//   cylinders  the same with capped cylinders, turned at random
//   triangles  the same with single triangles
//   objects    the same with all three in turn, and boxes: what a student's ray tracer is shown
//   models     a mesh of `triangles`, `spheres` spheres about it, `lights` point lights, seen from `distance`
//   bars       `count` instances of a bar ten times as long as thick, of `triangles`, turned at random
#pragma once

#include "framework/core/error.h"
#include "framework/scene/scene.h"

namespace etendue {

// Any name load_scene takes, or one of the above. Both throw Error.
Scene load_claim_scene(const std::string& name);
void check_claim_scene(const std::string& name, const Location& where);

}  // namespace etendue
