// Built-in scenes without a closed form, each there for what it asks of a method.
#pragma once

#include "framework/scene/scene.h"

namespace etendue {

Scene make_cornell_box();      // diffuse interreflection
Scene make_cornell_spheres();  // a mirror and a glass sphere: caustics, directly seen
Scene make_glass_caustic();    // a caustic under glass, also seen through a mirror: SDS paths
Scene make_two_rooms();        // light comes through a door ajar
Scene make_veach_mis();        // four plates of growing roughness, four spheres of growing size

}  // namespace etendue
