#include "framework/io/mesh/ply.h"
#include "tests/unit/io_helpers.h"

#include <algorithm>
#include <cstring>

namespace etendue {
namespace {

// Two triangles as one quad, then one triangle; normals, texture coordinates, and things to skip.
const std::string header_body = R"(comment made by hand
obj_info nothing
element vertex 5
property float x
property float y
property double z
property uchar red
property float nx
property float ny
property float nz
property list uchar short extra
property float s
property float t
element edge 2
property int a
property list ushort float weights
element face 2
property uchar flags
property list uchar uint vertex_indices
property list uchar float texcoord
end_header
)";

std::string ascii_ply() {
  return "ply\nformat ascii 1.0\n" + header_body +
         "0 0 0 255 0 0 1 0 0 0\n"
         "1 0 0 255 0 0 1 2 7 8 1 0\n"
         "1 1 0 255 0 0 1 0 1 1\n"
         "0 1 0.5 255 0 0 2 0 0 1\n"
         "-2 0.25 1e-3 255 0 1 0 1 -5 0.5 0.5\n"
         "3 2 0.5 0.25\n4 0\n"
         "1 4 0 1 2 3 2 0.5 0.5\n"
         "0 3 4 0 2 0\n";
}

class Packer {
 public:
  explicit Packer(bool big_endian) : big_endian_(big_endian) {}
  template <class T>
  Packer& put(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian_) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
    return *this;
  }
  std::string bytes;

 private:
  bool big_endian_;
};

std::string binary_ply(bool big_endian, const std::string& line_end = "\n") {
  Packer p(big_endian);
  const auto vertex = [&](float x, float y, double z, float nx, float ny, float nz, std::initializer_list<std::int16_t> extra,
                          float s, float t) {
    p.put(x).put(y).put(z).put(std::uint8_t{255}).put(nx).put(ny).put(nz).put(static_cast<std::uint8_t>(extra.size()));
    for (const std::int16_t e : extra) p.put(e);
    p.put(s).put(t);
  };
  vertex(0, 0, 0, 0, 0, 1, {}, 0, 0);
  vertex(1, 0, 0, 0, 0, 1, {7, 8}, 1, 0);
  vertex(1, 1, 0, 0, 0, 1, {}, 1, 1);
  vertex(0, 1, 0.5, 0, 0, 2, {}, 0, 1);
  vertex(-2, 0.25f, 1e-3, 0, 1, 0, {-5}, 0.5f, 0.5f);
  p.put(3).put(std::uint16_t{2}).put(0.5f).put(0.25f);
  p.put(4).put(std::uint16_t{0});
  p.put(std::uint8_t{1}).put(std::uint8_t{4});
  for (const std::uint32_t i : {0u, 1u, 2u, 3u}) p.put(i);
  p.put(std::uint8_t{2}).put(0.5f).put(0.5f);
  p.put(std::uint8_t{0}).put(std::uint8_t{3});
  for (const std::uint32_t i : {4u, 0u, 2u}) p.put(i);
  p.put(std::uint8_t{0});
  std::string header =
      std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" + header_body;
  std::string ended;
  for (const char c : header) ended += c == '\n' ? line_end : std::string(1, c);
  return ended + p.bytes;
}

void expect_the_mesh(const TriangleMesh& mesh) {
  ASSERT_EQ(mesh.positions.size(), 5u);
  ASSERT_EQ(mesh.normals.size(), 5u);
  ASSERT_EQ(mesh.uvs.size(), 5u);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.positions[3], vec3(0, 1, 0.5f));
  EXPECT_EQ(mesh.positions[4], vec3(-2, 0.25f, 1e-3f));
  EXPECT_EQ(mesh.normals[3], vec3(0, 0, 1)) << "made unit";
  EXPECT_EQ(mesh.uvs[2], vec2(1, 1));
  EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
  EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
  EXPECT_EQ(mesh.triangles[2], uvec3(4, 0, 2));
}

// A triangle whose header or body differs from the good one.
std::string triangle_ply(const std::string& vertex_count, const std::string& face_count, const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex " + vertex_count +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + face_count +
         "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}
const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";

TEST(PlyReader, AsciiWithOtherPropertiesGivesMesh) { expect_the_mesh(parse_ply(ascii_ply(), "m.ply")); }

TEST(PlyReader, BothByteOrdersGiveTheSameMesh) {
  expect_the_mesh(parse_ply(binary_ply(false), "m.ply"));
  expect_the_mesh(parse_ply(binary_ply(true), "m.ply"));
}

TEST(PlyReader, CarriageReturnsInHeaderAreLineEnds) { expect_the_mesh(parse_ply(binary_ply(false, "\r\n"), "m.ply")); }

TEST(PlyReader, FileIsReadFromDisk) {
  const TestDirectory directory;
  expect_the_mesh(read_ply(directory.write("m.ply", binary_ply(false))));
  EXPECT_ERROR(read_ply(directory.path("absent.ply")), "absent.ply': No such file");
  EXPECT_ERROR(read_ply(directory.path("")), "directory");
  EXPECT_ERROR(read_ply(directory.write("packed.ply", "\x1f\x8b rest")), "gzip");
}

TEST(PlyReader, FacesBeforeVerticesAreRead) {
  const TriangleMesh mesh = parse_ply(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\nproperty float "
      "x\nproperty float y\n"
      "property float z\nend_header\n3 2 1 0\n" +
          corners,
      "m.ply");
  EXPECT_EQ(mesh.triangles.at(0), uvec3(2, 1, 0));
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(PlyReader, UnusableNormalIsReplacedByItsSurroundings) {
  const auto with_normals = [](const std::string& body) {
    return parse_ply(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
        "property float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
            body,
        "m.ply");
  };
  const TriangleMesh mesh = with_normals("0 0 0 0 0 -1\n1 0 0 0 0 0\n0 1 0 nan 0 1\n3 0 1 2\n");
  EXPECT_EQ(mesh.normals.at(1), vec3(0, 0, -1)) << "on the side of the usable one";
  EXPECT_EQ(mesh.normals.at(2), vec3(0, 0, -1));
  EXPECT_TRUE(with_normals("0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n").normals.empty());
}

TEST(PlyReader, AsciiErrorsNameTheirPlace) {
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"), "m.ply"),
               "m.ply:11:3: expected a number, found 'x'");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", "0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n"), "m.ply"),
               "m.ply:11:3: coordinate y of vertex 1 is not finite");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 1 3\n"), "m.ply"),
               "m.ply:13:7: face 0 refers to vertex 3, but there are 3");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 -1 2\n"), "m.ply"), "m.ply:13:5: face 0 refers to vertex -1");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 1.5 2\n"), "m.ply"), "refers to vertex 1.5");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "2 0 1\n"), "m.ply"), "m.ply: no faces: each has less than three");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "2", corners + "2 0 3\n3 0 1 2\n"), "m.ply"), "face 0 refers to vertex 3");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "200 0 1\n"), "m.ply"), "does not fit");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "-3 0 1 2\n"), "m.ply"), "a list of -3 values");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 1"), "m.ply"), "m.ply:13:1: a list of 3 values");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 1     "), "m.ply"),
               "m.ply:13:11: the file ends before its data does");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "1", corners + "3 0 1 2\n3 0 1 2\n"), "m.ply"), "m.ply:14:1: '3' follows the data");
}

// An arrowhead, whose corner at the notch comes third, and a convex pentagon.
TEST(PlyReader, PolygonsThatAreNotConvexAreTold) {
  const auto warnings = [](const std::string& count, const std::string& vertices, const std::string& face) {
    return parse_ply(triangle_ply(count, "1", vertices + face), "m.ply").warnings;
  };
  const std::string arrow = "0 0 0\n4 2 0\n1 2 0\n0 4 0\n", pentagon = "0 0 0\n2 0 0\n3 1 0\n1 2 0\n0 1 0\n";
  EXPECT_TRUE(warnings("4", arrow, "4 2 3 0 1\n").empty()) << "from the notch on its fan is right";
  ASSERT_EQ(warnings("4", arrow, "4 1 2 3 0\n").size(), 1u);
  EXPECT_TRUE(contains(warnings("4", arrow, "4 1 2 3 0\n")[0], "m.ply: 1 polygons are not convex"));
  EXPECT_TRUE(warnings("5", pentagon, "5 0 1 2 3 4\n").empty());
  EXPECT_EQ(warnings("5", pentagon, "5 0 2 1 3 4\n").size(), 1u);
}

TEST(PlyReader, FacesThatAreNoneAreLeftOut) {
  const TriangleMesh mesh = parse_ply(triangle_ply("3", "3", corners + "2 0 1\n3 0 1 2\n0\n"), "m.ply");
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
  ASSERT_EQ(mesh.warnings.size(), 1u);
  EXPECT_EQ(mesh.warnings[0], "m.ply: 2 faces of less than three vertices were left out");
  std::string strips = triangle_ply("3", "1", corners + "3 0 1 2\n");
  strips.replace(strips.find("element face"), 12, "element tristrips");
  EXPECT_ERROR(parse_ply(strips, "m.ply"), "m.ply:7:9: strips of triangles are not read; expected element 'face'");
}

TEST(PlyReader, LyingHeaderIsRefusedBeforeAllocation) {
  EXPECT_ERROR(parse_ply(triangle_ply("4000000000", "1", corners + "3 0 1 2\n"), "m.ply"),
               "announces 4000000000 rows of element 'vertex'");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "18446744073709551615", corners + "3 0 1 2\n"), "m.ply"), "rows of element 'face'");
  EXPECT_ERROR(parse_ply(triangle_ply("99999999999999999999", "1", corners), "m.ply"), "m.ply:3:16: expected a count");
}

TEST(PlyReader, HeaderErrorsNameTheirPlace) {
  EXPECT_ERROR(parse_ply("", "m.ply"), "m.ply:1:1: expected 'ply'");
  EXPECT_ERROR(parse_ply("plyx\n", "m.ply"), "expected 'ply'");
  EXPECT_ERROR(parse_ply("ply\nformat text 1.0\n", "m.ply"), "m.ply:2:8: unknown format; expected ascii");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 2.0\n", "m.ply"), "m.ply:2:14: expected version 1.0");
  EXPECT_ERROR(parse_ply("ply\nelement vertex 3\nend_header\n", "m.ply"), "no 'format'");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nproperty float x\n", "m.ply"), "m.ply:3:1: a property before");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n", "m.ply"),
               "m.ply:4:10: unknown type 'real'");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float x\n", "m.ply"),
               "declared twice");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x y\n", "m.ply"),
               "m.ply:4:18: unexpected 'y'");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nelement vertex 3\n", "m.ply"), "declared twice");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_indices\n", "m.ply"),
               "integer type for the list's count");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar float vertex_indices\n", "m.ply"),
               "list of integers");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\n", "m.ply"), "no 'end_header'");
  EXPECT_ERROR(parse_ply(triangle_ply("3", "0", corners), "m.ply"), "no faces");
  EXPECT_ERROR(parse_ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nelement face 1\n"
                         "property list uchar int vertex_indices\nend_header\n0 0\n3 0 0 0\n",
                         "m.ply"),
               "m.ply:3:9: element 'vertex' lacks x, y or z");
  EXPECT_ERROR(
      parse_ply(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
          "property int vertex_count\nend_header\n0 0 0\n3\n",
          "m.ply"),
      "lacks the list vertex_indices");
}

TEST(PlyReader, BinaryErrorsNameTheirByte) {
  const std::string good = binary_ply(false);
  const std::size_t body = good.find("end_header\n") + 11;
  EXPECT_ERROR(parse_ply(good.substr(0, good.size() - 1), "m.ply"), "m.ply: byte ");
  EXPECT_ERROR(parse_ply(good.substr(0, good.size() - 1), "m.ply"), "the file ends before");
  std::string bad = good;
  bad.replace(body + 4, 4, "\xff\xff\xff\x7f");  // y of the first vertex: NaN
  EXPECT_ERROR(parse_ply(bad, "m.ply"), "m.ply: byte " + std::to_string(body + 4) + ": coordinate y of vertex 0 is not finite");
  EXPECT_ERROR(parse_ply(good + "more", "m.ply"), "4 bytes follow the data");
  expect_the_mesh(parse_ply(good + "\n", "m.ply"));
}

TEST(PlyReader, DamagedFilesNeitherCrashNorHang) {
  const auto read = [](const std::string& bytes) { parse_ply(bytes, "m.ply"); };
  damage(ascii_ply(), 2000, read);
  damage(binary_ply(false), 2000, read);
  damage(binary_ply(true), 2000, read);
}

}  // namespace
}  // namespace etendue
