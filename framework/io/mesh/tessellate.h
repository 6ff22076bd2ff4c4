// Triangle meshes of curved surfaces that no ray structure holds as they are: parts of quadrics, tubes and strips along curves.
//
// A full turn takes 200 segments, so that a chord lies within 1.3e-4 of a radius of its arc; normals are exact at vertices.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <functional>
#include <span>

namespace etendue {

struct PatchPoint {
  vec3 position, normal;  // the normal need not be unit; it tells the outer side
};

// A surface over the unit square of (u, v), with the number of cells that it takes to follow it.
struct SurfacePatch {
  std::function<PatchPoint(float u, float v)> at;
  int columns = 1, rows = 1;  // along u and along v
};

// The cells that an arc takes.
int arc_segments(float radians);

// Sine and cosine of an angle from the +z axis, the sine exactly 0 at the poles, where cells then have no area.
vec2 from_pole(float theta);

// A surface of revolution about z: `profile(v)` gives radius and height, `slope(v)` their derivatives; u = 0 lies over +x.
SurfacePatch revolved(float radians, int rows, std::function<vec2(float)> profile, std::function<vec2(float)> slope);

// A mesh with the texture coordinates (u, v); cells of no area have no triangles.
TriangleMesh tessellate(const SurfacePatch& patch);

// A Bezier curve of degree 2 or 3 by its control points.
struct CurveSegment {
  std::vector<vec3> points;
  float width_at_start = 1, width_at_end = 1;
};
// A tube whose diameter is the width.
SurfacePatch tube_along(const CurveSegment& curve);
// A flat strip, as wide as the width, facing normals that turn evenly from one to the other.
SurfacePatch strip_along(const CurveSegment& curve, const vec3& normal_at_start, const vec3& normal_at_end);

}  // namespace etendue
