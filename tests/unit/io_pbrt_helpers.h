// Shared by the tests of the pbrt reader: scenes of a few lines, and what became of them.
#pragma once

#include "framework/io/pbrt/pbrt.h"
#include "tests/unit/io_helpers.h"

namespace etendue {

inline const std::string triangle = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

inline Scene world(const std::string& text) { return parse_pbrt("Camera \"perspective\"\nWorldBegin\n" + text, "s.pbrt"); }
// The scene as it is read where approximations are allowed.
inline Scene approximated(const std::string& text) {
  return parse_pbrt("Camera \"perspective\"\nWorldBegin\n" + text, "s.pbrt", {.approximate = true});
}
template <class T>
T approximate_material_of(const std::string& directive) {
  const Scene scene = approximated(directive + "\n" + triangle);
  return std::get<T>(scene.materials.at(scene.objects[0].shapes.at(0).material));
}
template <class T>
T material_of(const std::string& directive) {
  const Scene scene = world(directive + "\n" + triangle);
  return std::get<T>(scene.materials.at(scene.objects[0].shapes.at(0).material));
}
template <class T>
T light_of(const std::string& directive) {
  return std::get<T>(world(directive + "\n" + triangle).lights.at(0));
}
inline void expect_near(const vec3& a, const vec3& b, float tolerance = 1e-5f) {
  EXPECT_TRUE(glm::length(a - b) <= tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

}  // namespace etendue
