// Shared by the tests of the Mitsuba reader: scenes of a few lines, and what became of them.
#pragma once

#include "framework/io/mitsuba/mitsuba.h"
#include "tests/unit/io_helpers.h"

namespace etendue::mitsuba_test {

inline const std::string rectangle = "<shape type=\"rectangle\"/>";

inline std::string scene_text(const std::string& inside, const std::string& version = "3.0.0") {
  return "<scene version=\"" + version + "\">\n" + inside + "\n</scene>";
}
inline Scene read(const std::string& inside, const std::string& version = "3.0.0", bool approximate = false) {
  return parse_mitsuba(scene_text(inside, version), "s.xml", {.confined = false, .approximate = approximate});
}
inline Scene approximated(const std::string& inside) { return read(inside, "3.0.0", true); }

template <class T>
T material_of(const std::string& bsdf, const std::string& version = "3.0.0", bool approximate = false) {
  const Scene scene = read("<shape type=\"rectangle\">" + bsdf + "</shape>", version, approximate);
  return std::get<T>(scene.materials.at(scene.objects[0].shapes.at(0).material));
}
template <class T>
T light_of(const std::string& emitter) {
  return std::get<T>(read(rectangle + emitter).lights.at(0));
}
inline void expect_near(const vec3& a, const vec3& b, float tolerance = 1e-4f) {
  EXPECT_LE(glm::length(a - b), tolerance) << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

}  // namespace etendue::mitsuba_test
