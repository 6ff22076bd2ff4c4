// Built-in scenes without a closed form, each there for what it asks of a method.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct GlossyBoxParams {
  float alpha = 0.15f;
};

template <class Visitor>
void describe(Visitor& v, GlossyBoxParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "GGX alpha", "roughness of the floor");
}

struct KeyholeParams {
  float size = 1;
};

template <class Visitor>
void describe(Visitor& v, KeyholeParams& p) {
  v.number("size", p.size, 0.01, 4, "of 20 cm x 35 cm", "of the keyhole");
}

Scene make_cornell_box();      // diffuse interreflection
Scene make_cornell_spheres();  // a mirror and a glass sphere: caustics, directly seen
Scene make_glass_caustic();    // a caustic under glass, also seen through a mirror: SDS paths
Scene make_two_rooms();        // light comes through a door ajar
Scene make_veach_mis();        // four plates of growing roughness, four spheres of growing size
// The box with boxes on a floor of brushed metal: too narrow a lobe for a cache of irradiance, wide enough for one of radiance.
Scene make_glossy_cornell_box(const GlossyBoxParams& params);
// A dark room beside a bright one: all its light comes through the keyhole of a door.
Scene make_keyhole(const KeyholeParams& params);
// A room with one window, high in a city in the sun: nearly all light falls where the camera does not look.
Scene make_exterior();

}  // namespace etendue
