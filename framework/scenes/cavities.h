// Exact scenes of spherical cavities: a sphere's form factor between any two of its elements is the same.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct CavityParams {
  float opening = 0.1f;
};

template <class Visitor>
void describe(Visitor& v, CavityParams& p) {
  v.number("opening", p.opening, 0.001, 0.6, "of the sphere's area", "the cap removed; 0.5: a hemisphere");
}

// A sphere without a cap in a unit environment, seen from inside. What comes through the opening comes through its rim's disc,
// so a disc of radiance 1 stands for the environment.
Scene make_cavity(const CavityParams& params);
// A glowing sphere inside a glowing sphere, both diffuse.
Scene make_concentric_spheres();

}  // namespace etendue
