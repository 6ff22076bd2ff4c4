// A hall of pillars lit by many small triangles: for how methods choose among lights. Their powers are spread over three orders
// of magnitude; together they have the same power and the same area whatever their number. They face away from the camera, so
// that an image's error is that of what they light, not of their own edges.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/builder.h"

namespace etendue {

struct ManyLightsParams {
  int lights = 1000;
};

template <class Visitor>
void describe(Visitor& v, ManyLightsParams& p) {
  v.integer("lights", p.lights, 1, 1'000'000, "lights", "small triangles spread over the hall");
}

Scene make_many_lights(const ManyLightsParams& params);

}  // namespace etendue
