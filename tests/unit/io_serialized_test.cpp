// Mitsuba's serialized meshes.
#include "framework/io/mesh/serialized.h"
#include "tests/unit/io_helpers.h"

#include <zlib.h>

namespace etendue {
namespace {

// One mesh of a triangle, as version 4 stores it.
std::string serialized(std::uint64_t announced_vertices = 3, bool whole = true) {
  std::string body;
  const auto add = [&](const auto& value) { body.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(std::uint32_t{0x1000});
  body += std::string("name\0", 5);
  add(announced_vertices);
  add(std::uint64_t{1});
  for (const vec3& p : {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}) add(p);
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

}  // namespace
}  // namespace etendue
