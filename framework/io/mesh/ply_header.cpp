#include "framework/io/mesh/ply_header.h"

#include "framework/io/text.h"

#include <fmt/format.h>

#include <charconv>

namespace etendue::ply {

namespace {

struct ScalarName {
  std::string_view name;
  Scalar scalar;
};
constexpr std::array<ScalarName, 16> scalar_names{{{"char", Scalar::i8},
                                                   {"int8", Scalar::i8},
                                                   {"uchar", Scalar::u8},
                                                   {"uint8", Scalar::u8},
                                                   {"short", Scalar::i16},
                                                   {"int16", Scalar::i16},
                                                   {"ushort", Scalar::u16},
                                                   {"uint16", Scalar::u16},
                                                   {"int", Scalar::i32},
                                                   {"int32", Scalar::i32},
                                                   {"uint", Scalar::u32},
                                                   {"uint32", Scalar::u32},
                                                   {"float", Scalar::f32},
                                                   {"float32", Scalar::f32},
                                                   {"double", Scalar::f64},
                                                   {"float64", Scalar::f64}}};

int vertex_slot(std::string_view name) {
  constexpr std::string_view names[slot_count] = {"x", "y", "z", "nx", "ny", "nz", "u", "v"};
  constexpr std::string_view aliases[][2] = {{"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
  for (int i = 0; i < slot_count; ++i)
    if (name == names[i]) return i;
  for (const auto& alias : aliases) {
    if (name == alias[0]) return 6;
    if (name == alias[1]) return 7;
  }
  return no_slot;
}

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name), words_(bytes) {}

  Header read() {
    if (next() != "ply") fail("expected 'ply', the first word of a PLY file");
    if (!next().empty()) fail("no PLY file: expected 'ply' alone on the first line");
    words_.next_line();
    bool has_format = false;
    for (;;) {
      if (words_.at_end()) fail("the header has no 'end_header'");
      const std::string_view keyword = next();
      if (keyword == "format") {
        read_format();
        has_format = true;
      } else if (keyword == "element") {
        read_element();
      } else if (keyword == "property") {
        read_property();
      } else if (keyword == "end_header") {
        break;
      } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
        fail("expected format, element, property, comment or end_header" + (has_format ? ", found " + quote(keyword) : ""));
      }
      keyword == "comment" || keyword == "obj_info" ? words_.next_line() : end_line();
    }
    end_line();
    if (!has_format) fail("the header has no 'format'");
    header_.body = words_.offset();
    return std::move(header_);
  }

 private:
  std::string_view next() {
    const std::string_view word = words_.word();
    word_ = words_.offset() - word.size();
    return word;
  }
  // Binary data may begin with the byte of a line end, so exactly one is taken.
  void end_line() {
    if (const std::string_view word = next(); !word.empty()) fail(fmt::format("unexpected {}", quote(word)));
    words_.next_line();
  }
  [[noreturn]] void fail(const std::string& what) const { throw Error(location_at(name_, bytes_, word_), what); }

  void read_format() {
    const std::string_view format = next();
    if (format == "ascii")
      header_.format = Format::ascii;
    else if (format == "binary_little_endian")
      header_.format = Format::little;
    else if (format == "binary_big_endian")
      header_.format = Format::big;
    else
      fail("unknown format; expected ascii, binary_little_endian or binary_big_endian");
    if (next() != "1.0") fail("expected version 1.0");
  }

  void read_element() {
    Element element;
    element.name = next();
    element.offset = word_;
    if (element.name.empty()) fail("expected the element's name");
    for (const Element& other : header_.elements)
      if (other.name == element.name) fail(fmt::format("element {} is declared twice", quote(element.name)));
    const std::string_view count = next();
    const auto [stop, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (error != std::errc() || stop != count.data() + count.size())
      fail(fmt::format("expected a count, found {}", quote(count)));
    header_.elements.push_back(std::move(element));
  }

  Scalar read_scalar() {
    const std::string_view type = next();
    for (const ScalarName& entry : scalar_names)
      if (entry.name == type) return entry.scalar;
    fail(fmt::format("unknown type {}; expected char, uchar, short, ushort, int, uint, float or double", quote(type)));
  }

  void read_property() {
    if (header_.elements.empty()) fail("a property before the first element");
    Element& element = header_.elements.back();
    Property property;
    const WordReader before = words_;
    if (next() == "list") {
      property.is_list = true;
      property.count_type = read_scalar();
      if (!is_integer(property.count_type)) fail("expected an integer type for the list's count");
    } else {
      words_ = before;
    }
    property.type = read_scalar();
    property.name = next();
    if (property.name.empty()) fail("expected the property's name");
    for (const Property& other : element.properties)
      if (other.name == property.name) fail(fmt::format("property {} is declared twice", quote(property.name)));
    if (element.name == "vertex" && !property.is_list) property.slot = vertex_slot(property.name);
    if (element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index")) {
      if (!property.is_list || !is_integer(property.type))
        fail(fmt::format("expected a list of integers for {}", property.name));
      property.is_indices = true;
    }
    element.properties.push_back(std::move(property));
  }

  std::string_view bytes_;
  const std::string& name_;
  WordReader words_;
  std::size_t word_ = 0;
  Header header_;
};

// The header must declare a mesh before the body is read.
void check_elements(const Header& header, std::string_view bytes, const std::string& name) {
  const Element *vertices = nullptr, *faces = nullptr;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") vertices = &element;
    if (element.name == "face") faces = &element;
    if (element.name == "tristrips" && element.count > 0)
      throw Error(location_at(name, bytes, element.offset), "strips of triangles are not read; expected element 'face'");
  }
  if (!vertices) throw Error(location_at(name, bytes, 0), "the header has no element 'vertex'");
  if (!faces || faces->count == 0) throw Error(location_at(name, bytes, faces ? faces->offset : 0), "no faces");
  bool has[slot_count] = {}, has_indices = false;
  for (const Property& p : vertices->properties) {
    if (p.slot == no_slot) continue;
    if (has[p.slot])
      throw Error(location_at(name, bytes, vertices->offset), fmt::format("two properties mean the same as '{}'", p.name));
    has[p.slot] = true;
  }
  for (const Property& p : faces->properties) {
    if (p.is_indices && has_indices) throw Error(location_at(name, bytes, faces->offset), "two lists of vertex indices");
    has_indices |= p.is_indices;
  }
  const Location at_vertices = location_at(name, bytes, vertices->offset);
  if (!has[0] || !has[1] || !has[2]) throw Error(at_vertices, "element 'vertex' lacks x, y or z");
  if (vertices->count >= 0xffffffffu) throw Error(at_vertices, fmt::format("{} vertices; at most 4294967294", vertices->count));
  if (!has_indices) throw Error(location_at(name, bytes, faces->offset), "element 'face' lacks the list vertex_indices");
}

}  // namespace

Header read_header(std::string_view bytes, const std::string& name) {
  Header header = HeaderReader(bytes, name).read();
  check_elements(header, bytes, name);
  return header;
}

}  // namespace etendue::ply
