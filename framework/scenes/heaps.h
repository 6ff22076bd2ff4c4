// Built-in scenes of triangles that boxes cannot tell apart, where structures take time and memory and no image goes wrong.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct CoincidentParams {
  int copies = 1;
};

template <class Visitor>
void describe(Visitor& v, CoincidentParams& p) {
  v.integer("copies", p.copies, 1, 10'000, "copies", "of a ball of 500 triangles, all in the same place");
}

struct SliversParams {
  float aspect = 1;
  int triangles = 5'000;
};

template <class Visitor>
void describe(Visitor& v, SliversParams& p) {
  v.number("aspect", p.aspect, 1, 1e5, "1", "length of the triangles over their width, of the same area at any");
  v.integer("triangles", p.triangles, 100, 5'000'000, "triangles", "in a cube of one metre");
}

struct OverlapParams {
  float spread = 10;
  int triangles = 2'000;
};

template <class Visitor>
void describe(Visitor& v, OverlapParams& p) {
  v.number("spread", p.spread, 0, 1e4, "triangles", "side of the cube in which the centroids lie; 0: all in one point");
  v.integer("triangles", p.triangles, 100, 5'000'000, "triangles", "of one metre");
}

Scene make_coincident(const CoincidentParams& params);  // a ray that meets one meets all copies
Scene make_slivers(const SliversParams& params);  // diagonal: the box of each is as long, wide and high as the triangle is long
Scene make_overlap(const OverlapParams& params);  // a ray meets as many boxes as overlap

}  // namespace etendue
