// Built-in scenes of one large mesh whose number of triangles is a parameter: for structures rather than for methods.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/builder.h"

namespace etendue {

// A displaced ball in the Cornell box: triangles of like size, spread evenly.
struct MeshParams {
  int triangles = 100'000;
};

template <class Visitor>
void describe(Visitor& v, MeshParams& params) {
  v.integer("triangles", params.triangles, 100, 50'000'000, "triangles", "of the ball, to within a percent");
}

// The ball, half a metre across, on the field of a stadium that is `size` times as wide: nearly all triangles lie in a tiny
// part of space.
struct StadiumParams {
  int triangles = 100'000;
  float size = 100;
};

template <class Visitor>
void describe(Visitor& v, StadiumParams& params) {
  v.integer("triangles", params.triangles, 100, 50'000'000, "triangles", "of the ball, to within a percent");
  v.number("size", params.size, 2, 100'000, "balls", "width of the stadium");
}

Scene make_mesh(const MeshParams& params);
Scene make_stadium(const StadiumParams& params);

// A ball displaced by five octaves of noise, on a grid of longitudes and latitudes; a quarter more of the former.
MeshData rough_ball(const vec3& centre, float radius, int triangles);

}  // namespace etendue
