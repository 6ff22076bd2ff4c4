#include "framework/io/mesh/ply_write.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

namespace etendue {

namespace {

void put_word(std::string& bytes, std::uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(word >> shift & 0xff);
}

template <class Vector>
void put_floats(std::string& bytes, const Vector& values) {
  for (int i = 0; i < values.length(); ++i) put_word(bytes, std::bit_cast<std::uint32_t>(values[i]));
}

}  // namespace

std::string encode_ply(const TriangleMesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  bytes += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.positions.size());
  if (!mesh.normals.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.uvs.empty()) bytes += "property float u\nproperty float v\n";
  bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.size());
  bytes.reserve(bytes.size() + mesh.positions.size() * 8 * sizeof(float) + mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    put_floats(bytes, mesh.positions[i]);
    if (!mesh.normals.empty()) put_floats(bytes, mesh.normals[i]);
    if (!mesh.uvs.empty()) put_floats(bytes, mesh.uvs[i]);
  }
  for (const uvec3& triangle : mesh.triangles) {
    bytes += '\3';
    for (int i = 0; i < 3; ++i) put_word(bytes, triangle[i]);
  }
  return bytes;
}

}  // namespace etendue
