// Scenes that lie far from the origin are moved there.
#pragma once

#include "framework/scene/scene.h"

namespace etendue {

// Moves everything in a scene by Scene::origin, along each axis on which its centre lies more than 16 times its extent from
// the origin. Floats are dense around the origin, so that a room 1,000 km away is rendered as one at the origin; and moving
// rounds no corner (x - y is exact where x lies between y / 2 and 2 y [Sterbenz1974, theorem 4.3.1]). What reading the file
// rounded away stays lost; precision_warnings tells of it.
void recentre(Scene& scene);

}  // namespace etendue
