// Exact scenes of light that reaches a diffuse floor by way of a specular surface, which the camera may look through as well.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct MirrorParams {
  std::string view = "floor";
};

template <class Visitor>
void describe(Visitor& v, MirrorParams& p) {
  v.choice("view", p.view, {"floor", "mirror", "both"}, "what fills the image: mirror, the floor seen in the mirror alone");
}

struct WaterParams {
  std::string camera = "below";
};

template <class Visitor>
void describe(Visitor& v, WaterParams& p) {
  v.choice("camera", p.camera, {"below", "above"}, "of the surface; above, each path to the floor is refracted twice");
}

// A point light before a vertical mirror on a diffuse floor. No light comes back to the floor: what it reflects goes up, and a
// vertical mirror sends it up.
Scene make_mirror(const MirrorParams& params);
// A point light above a flat water surface and a diffuse floor below it. Paths end at three events, before the floor lights
// itself by way of the surface.
Scene make_water(const WaterParams& params);

// Irradiance on the floor at horizontal distance x from a point light of 1 W/sr, `height` above a flat surface with index eta
// below it, `depth` above the floor.
double refracted_irradiance(double x, double height, double depth, double eta);

}  // namespace etendue
