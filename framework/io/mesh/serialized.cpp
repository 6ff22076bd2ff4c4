// A file is a number of meshes and, at its end, their offsets and their count. A mesh is a header of four bytes and a zlib
// stream: flags, in version 4 a name, the numbers of vertices and triangles, then positions, normals, texture coordinates and
// colours, each for all vertices, and indices. All is little-endian.

#include "framework/io/mesh/serialized.h"

#include "framework/core/error.h"
#include "framework/core/memory.h"

#include <zlib.h>

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace etendue {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint32_t has_normals = 1, has_uvs = 2, has_colours = 8, face_normals = 16, is_double = 0x2000;
constexpr std::uint64_t most_deflated = 1032;  // deflate packs at most 1 : 1032

[[noreturn]] void fail(const std::string& name, std::uint64_t byte, const std::string& what) {
  throw Error(fmt::format("{}: byte {}: {}", name, byte, what));
}

template <class T>
T value_at(std::string_view bytes, std::uint64_t at, const std::string& name) {
  if (at > bytes.size() || bytes.size() - at < sizeof(T)) fail(name, at, "the file is cut short");
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

class Inflater {
 public:
  Inflater(std::string_view bytes, std::uint64_t at, const std::string& name) : name_(name), at_(at) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + at));
    // What is longer than an int can count is no mesh of this format's.
    stream_.avail_in = static_cast<uInt>(std::min<std::uint64_t>(bytes.size() - at, 0xffffffffu));
    if (inflateInit(&stream_) != Z_OK) fail(name, at, "zlib does not start");
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  void read(void* out, std::uint64_t size) {
    auto* next = static_cast<Bytef*>(out);
    while (size > 0) {
      const auto wanted = static_cast<uInt>(std::min<std::uint64_t>(size, 1u << 30));
      stream_.next_out = next;
      stream_.avail_out = wanted;
      const int status = inflate(&stream_, Z_NO_FLUSH);
      const uInt got = wanted - stream_.avail_out;
      next += got;
      size -= got;
      if (size > 0 && (status == Z_STREAM_END || (status == Z_OK && got == 0) || status == Z_BUF_ERROR))
        fail(name_, at_ + stream_.total_in, fmt::format("the mesh is cut short: {} bytes are missing", size));
      if (status != Z_OK && status != Z_STREAM_END) fail(name_, at_ + stream_.total_in, "the compressed data are damaged");
    }
  }
  template <class T>
  T value() {
    T value;
    read(&value, sizeof value);
    return value;
  }
  // Throws where the stream cannot hold so many bytes.
  void expect(std::uint64_t count, std::uint64_t bytes_each) {
    const std::uint64_t most = most_deflated * (std::uint64_t{stream_.avail_in} + 64);
    if (count > most / bytes_each)
      fail(name_, at_, fmt::format("the mesh announces {} vertices or triangles, more than the file can hold", count));
  }

 private:
  z_stream stream_ = {};
  const std::string& name_;
  std::uint64_t at_;
};

template <class Vector>
std::vector<Vector> read_vectors(Inflater& in, std::uint64_t count, bool of_doubles) {
  std::vector<Vector> values(count);
  if (!of_doubles) {
    in.read(values.data(), count * sizeof(Vector));
    return values;
  }
  for (Vector& v : values)
    for (int i = 0; i < Vector::length(); ++i) v[i] = static_cast<float>(in.value<double>());
  return values;
}

std::uint64_t offset_of(std::string_view bytes, const std::string& name, int index, bool wide) {
  const std::uint64_t size = bytes.size();
  if (size < 4) fail(name, 0, "the file is cut short");
  const std::uint64_t count = value_at<std::uint32_t>(bytes, size - 4, name), entry = wide ? 8 : 4;
  if (count == 0 || count > (size - 4) / entry)
    fail(name, size - 4, fmt::format("the file announces {} meshes, more than it holds", count));
  if (static_cast<std::uint64_t>(index) >= count)
    throw Error(fmt::format("{}: has {} meshes; expected a shape index of 0 to {}, not {}", name, count, count - 1, index));
  const std::uint64_t at = size - 4 - entry * (count - static_cast<std::uint64_t>(index));
  return wide ? value_at<std::uint64_t>(bytes, at, name) : value_at<std::uint32_t>(bytes, at, name);
}

std::uint16_t checked_version(std::string_view bytes, std::uint64_t at, const std::string& name) {
  constexpr std::uint16_t magic = 0x041c;
  if (value_at<std::uint16_t>(bytes, at, name) != magic) fail(name, at, "no serialized mesh: expected the bytes 1c 04");
  const auto version = value_at<std::uint16_t>(bytes, at + 2, name);
  if (version != 3 && version != 4) fail(name, at + 2, fmt::format("version {}; expected 3 or 4", version));
  return version;
}

}  // namespace

TriangleMesh parse_serialized(std::string_view bytes, const std::string& name, int index) {
  const std::uint16_t version = checked_version(bytes, 0, name);
  const std::uint64_t at = offset_of(bytes, name, index, version == 4);
  checked_version(bytes, at, name);
  Inflater in(bytes, at + 4, name);
  const auto flags = in.value<std::uint32_t>();
  if (version == 4)
    for (int length = 0; in.value<char>() != 0; ++length)
      if (length > 4096) fail(name, at, "the mesh's name has more than 4096 bytes");
  const bool doubles = (flags & is_double) != 0;
  const auto vertices = in.value<std::uint64_t>(), triangles = in.value<std::uint64_t>();
  const std::uint64_t bytes_each =
      (doubles ? 8 : 4) * (3 + (flags & has_normals ? 3 : 0) + (flags & has_uvs ? 2 : 0) + (flags & has_colours ? 3 : 0));
  in.expect(vertices, bytes_each);
  in.expect(triangles, 12);
  if (vertices > 0xffffffffu || triangles > 0xffffffffu) fail(name, at, "more than 4,294,967,295 vertices or triangles");
  if (triangles == 0) fail(name, at, "the mesh has no triangles");
  require_memory(static_cast<double>(vertices) * 44 + static_cast<double>(triangles) * 12, {}, name, "a smaller mesh");
  TriangleMesh mesh;
  mesh.positions = read_vectors<vec3>(in, vertices, doubles);
  if (flags & has_normals) mesh.normals = read_vectors<vec3>(in, vertices, doubles);
  if (flags & has_uvs) mesh.uvs = read_vectors<vec2>(in, vertices, doubles);
  if (flags & has_colours) read_vectors<vec3>(in, vertices, doubles);
  mesh.triangles.resize(triangles);
  in.read(mesh.triangles.data(), triangles * sizeof(uvec3));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    if (!is_finite(mesh.positions[i])) throw Error(fmt::format("{}: the position of vertex {} is not finite", name, i));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int corner = 0; corner < 3; ++corner)
      if (mesh.triangles[i][corner] >= vertices)
        throw Error(fmt::format("{}: triangle {} names vertex {}; there are {}", name, i, mesh.triangles[i][corner], vertices));
  mesh.face_normals = (flags & face_normals) != 0;
  return mesh;
}

}  // namespace etendue
