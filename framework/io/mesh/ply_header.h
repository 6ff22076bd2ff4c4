// The contents that a PLY header declares.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace etendue::ply {

enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

inline std::size_t size_of(Scalar s) {
  constexpr std::array<std::size_t, 8> bytes{1, 1, 2, 2, 4, 4, 4, 8};
  return bytes[static_cast<std::size_t>(s)];
}
inline bool is_integer(Scalar s) { return s != Scalar::f32 && s != Scalar::f64; }

inline constexpr int no_slot = -1, slot_count = 8;  // x y z nx ny nz u v

struct Property {
  std::string name;
  Scalar type = Scalar::f32;
  bool is_list = false;
  Scalar count_type = Scalar::u8;
  int slot = no_slot;       // of a vertex property
  bool is_indices = false;  // of a face property
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
  std::size_t offset = 0;  // of its name in the header
};

enum class Format : std::uint8_t { ascii, little, big };

struct Header {
  Format format = Format::ascii;
  std::vector<Element> elements;
  std::size_t body = 0;  // offset of the first byte after the header
};

// Reads and checks the header: a mesh must have vertices with x, y and z, and faces with one list of vertex indices. Throws
// Error at `name:line:col`.
Header read_header(std::string_view bytes, const std::string& name);

}  // namespace etendue::ply
