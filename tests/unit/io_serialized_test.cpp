// Mitsuba's serialized meshes.
#include "framework/io/mesh/serialized.h"

#include "framework/io/mitsuba/mitsuba.h"
#include "tests/unit/io_helpers.h"

#include <zlib.h>

namespace etendue {
namespace {

// One mesh of a triangle, as version 4 stores it; `faceted`: it has normals, and says that it does not want them.
std::string serialized(std::uint64_t announced_vertices = 3, bool whole = true, bool faceted = false) {
  std::string body;
  const auto add = [&](const auto& value) { body.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(std::uint32_t{0x1000u | (faceted ? 0x11u : 0u)});
  body += std::string("name\0", 5);
  add(announced_vertices);
  add(std::uint64_t{1});
  for (const vec3& p : {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}) add(p);
  for (int i = 0; faceted && i < 3; ++i) add(vec3(1, 0, 0));
  add(uvec3(0, 1, 2));
  std::string packed(1000, '\0');
  uLongf size = packed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(body.data()), body.size()),
            Z_OK);
  packed.resize(whole ? size : size / 2);
  std::string file("\x1c\x04\x04\x00", 4);
  file += packed;
  file += std::string(8, '\0') + std::string("\1\0\0\0", 4);
  return file;
}

TEST(SerializedMesh, IsReadOrRefused) {
  const TriangleMesh mesh = parse_serialized(serialized(), "m.serialized", 0);
  EXPECT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.triangles.at(0), uvec3(0, 1, 2));
  EXPECT_ERROR(parse_serialized(serialized(), "m", 1), "has 1 meshes; expected a shape index of 0 to 0, not 1");
  EXPECT_ERROR(parse_serialized(serialized(std::uint64_t{1} << 60), "m", 0), "more than the file can hold");
  EXPECT_ERROR(parse_serialized(serialized(3, false), "m", 0), "m: byte ");
  EXPECT_ERROR(parse_serialized("v 1 2 3 4 5", "m", 0), "no serialized mesh");
  damage(serialized(), 2000, [](const std::string& damaged) { parse_serialized(damaged, "m", 0); });
}

// Versions from 2 on do not ask the file.
TEST(SerializedMesh, IsFacetedWhereItsFileSaysSoToVersion0) {
  const TestDirectory directory;
  directory.write("m.serialized", serialized(3, true, true));
  const auto has_normals = [&](const std::string& version, const std::string& inside) {
    const std::string text = "<scene version=\"" + version +
                             "\"><shape type=\"serialized\"><string name=\"filename\" value=\"m.serialized\"/>" + inside +
                             "</shape></scene>";
    return parse_mitsuba(text, directory.path("s.xml")).objects[0].shapes[0].has_normals;
  };
  EXPECT_FALSE(has_normals("0.5.0", ""));
  EXPECT_TRUE(has_normals("3.0.0", ""));
  EXPECT_FALSE(has_normals("3.0.0", "<boolean name=\"face_normals\" value=\"true\"/>"));
}

}  // namespace
}  // namespace etendue
