// tinyobjloader is lenient: it reads "1..5" as 1, drops faces it does not understand, and reads tags and materials that are of
// no use here. So the text is checked first, line by line, and everything but v, vt, vn, f and fo lines is blanked out before
// the loader sees it. Blanking keeps every byte's place, so that places in messages are those of the file. Numbers are kept
// from the check too: the loader's are not correctly rounded, and its 0e999 is NaN. It triangulates, and resolves indices.
// Where parts are kept apart, lines of smoothing groups, which say nothing here, take their numbers to the triangles.

#include "framework/io/mesh/obj.h"

#include "framework/core/check.h"
#include "framework/io/text.h"

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <istream>
#include <map>
#include <optional>
#include <streambuf>

namespace etendue {

namespace {

// Ear clipping takes time quadratic in the corners.
constexpr std::size_t most_corners = 4096;

// Ends of lines that a backslash continues become blanks, and so do comments and a byte order mark.
void join_lines(std::string& text) {
  if (text.starts_with(byte_order_mark)) std::fill_n(text.begin(), byte_order_mark.size(), ' ');
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '#') {
      for (; i < text.size() && text[i] != '\n' && text[i] != '\r'; ++i) text[i] = ' ';
    } else if (text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == '\n' || text[i + 1] == '\r')) {
      const bool two = text[i + 1] == '\r' && i + 2 < text.size() && text[i + 2] == '\n';
      std::fill_n(text.begin() + static_cast<std::ptrdiff_t>(i), two ? 3 : 2, ' ');
    }
  }
}

class Checker {
 public:
  Checker(std::string& text, const std::string& original, const std::string& name)
      : text_(text), original_(original), name_(name), words_(text) {}

  // Throws on the first thing that is wrong. Blanks out the lines that are not geometry.
  void check() {
    for (; !words_.at_end(); words_.next_line()) {
      const std::string_view keyword = next();
      if (keyword == "v")
        check_numbers(keyword, 3, 8, 0);
      else if (keyword == "vt")
        check_numbers(keyword, 1, 3, 1);
      else if (keyword == "vn")
        check_numbers(keyword, 3, 3, 2);
      else if (keyword == "f" || keyword == "fo")
        check_face(keyword);
      else
        blank_line(keyword);
    }
    for (int kind = 0; kind < 3; ++kind)
      if (largest_[kind].index > count(kind)) fail_index(largest_[kind], kind);
    if (triangles_ == 0) throw Error(Location{name_}, "no faces");
  }

  std::size_t triangles() const { return triangles_; }
  const std::vector<vec3>& positions() const { return values_[0]; }
  const std::vector<vec3>& uvs() const { return values_[1]; }
  const std::vector<vec3>& normals() const { return values_[2]; }
  bool names_materials() const { return names_materials_; }
  // A part that has no faces keeps its number.
  const std::string& material_of(std::size_t part) const { return names_[name_of_part_[part]]; }
  const std::string& last_material() const { return names_.back(); }
  std::string text_with_part_numbers() const {
    std::string marked;
    std::size_t from = 0;
    for (std::size_t part = 1; part < part_starts_.size(); ++part) {
      marked += std::string_view(text_).substr(from, part_starts_[part] - from);
      marked += fmt::format("s {}\n", part);
      from = part_starts_[part];
    }
    return marked + text_.substr(from);
  }

 private:
  struct Reference {
    std::int64_t index = 0;
    std::size_t offset = 0;
  };

  std::int64_t count(int kind) const { return static_cast<std::int64_t>(values_[kind].size()); }
  std::string_view next() {
    const std::string_view word = words_.word();
    word_ = words_.offset() - word.size();
    return word;
  }
  [[noreturn]] void fail(std::size_t offset, const std::string& what) const {
    throw Error(location_at(name_, original_, offset), what);
  }

  // A file without a vertex may be no mesh, so nothing of it is shown.
  std::string found(std::string_view word) const { return values_[0].empty() ? "" : ", found " + quote(word); }

  void check_numbers(std::string_view keyword, int least, int most, int kind) {
    vec3 value(0);
    int numbers = 0;
    for (std::string_view word = next(); !word.empty(); word = next(), ++numbers) {
      const auto number = parse_number(word);
      if (!number) fail(word_, "expected a number" + found(word));
      if (numbers < 3) value[numbers] = static_cast<float>(*number);
    }
    if (numbers < least || numbers > most)
      fail(word_, fmt::format("expected {} numbers after '{}', found {}",
                              least == most ? fmt::to_string(least) : fmt::format("{} to {}", least, most), keyword, numbers));
    values_[kind].push_back(value);
  }

  // Old files write fo, which the loader does not know.
  void check_face(std::string_view keyword) {
    std::fill_n(text_.begin() + static_cast<std::ptrdiff_t>(word_) + 1, keyword.size() - 1, ' ');
    std::size_t corners = 0;
    for (std::string_view word = next(); !word.empty(); word = next(), ++corners) check_corner(word);
    if (corners < 3) fail(word_, fmt::format("a face needs 3 vertices or more, found {}", corners));
    if (corners > most_corners) fail(word_, fmt::format("a polygon of {} vertices; at most {}", corners, most_corners));
    triangles_ += corners - 2;
  }

  // v, v/vt, v//vn or v/vt/vn, and v/, v// or v/vt/, whose last slashes the loader does not know.
  void check_corner(std::string_view word) {
    if (std::count(word.begin(), word.end(), '/') > 2) fail_corner(word);
    std::string_view rest = word.substr(0, word.find_last_not_of('/') + 1);
    std::fill_n(text_.begin() + static_cast<std::ptrdiff_t>(word_ + rest.size()), word.size() - rest.size(), ' ');
    for (int kind = 0;; ++kind) {
      const std::size_t slash = std::min(rest.find('/'), rest.size());
      if (slash > 0) check_index(rest.substr(0, slash), kind, word);
      const bool may_be_empty = kind == 1 && slash < rest.size();
      if ((slash == 0 && !may_be_empty) || (kind == 2 && slash < rest.size())) fail_corner(word);
      if (slash == rest.size()) return;
      rest.remove_prefix(slash + 1);
    }
  }
  [[noreturn]] void fail_corner(std::string_view word) const {
    fail(word_, "expected a face's vertex as v, v/vt, v//vn or v/vt/vn" + found(word));
  }

  void check_index(std::string_view digits, int kind, std::string_view word) {
    Reference reference{0, word_};
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), reference.index);
    if (error != std::errc() || stop != digits.data() + digits.size()) fail_corner(word);
    if (reference.index == 0 || reference.index < -count(kind) || reference.index > 0x7fffffff) fail_index(reference, kind);
    if (reference.index > largest_[kind].index) largest_[kind] = reference;
  }
  [[noreturn]] void fail_index(const Reference& reference, int kind) const {
    constexpr const char* what[] = {"vertex", "texture coordinate", "normal"};
    fail(reference.offset, fmt::format("index {} of a {}, but there are {}{} (indices count from 1, or back from -1)",
                                       reference.index, what[kind], count(kind), reference.index < 0 ? " before it" : ""));
  }

  void blank_line(std::string_view keyword) {
    names_materials_ |= keyword == "mtllib";
    const std::size_t begin = word_, of_keyword = keyword.size();
    const bool of_part = keyword == "g", of_material = keyword == "usemtl";
    while (!next().empty()) {
    }
    if (of_part || of_material) {
      part_starts_.push_back(begin);
      if (of_material) {
        std::string& rest = names_.emplace_back(text_.substr(begin + of_keyword, words_.offset() - begin - of_keyword));
        rest.erase(0, rest.find_first_not_of(" \t"));
        rest.erase(rest.find_last_not_of(" \t") + 1);
      }
      name_of_part_.push_back(static_cast<std::uint32_t>(names_.size() - 1));
    }
    std::fill(text_.begin() + static_cast<std::ptrdiff_t>(begin), text_.begin() + static_cast<std::ptrdiff_t>(words_.offset()),
              ' ');
  }

  std::string& text_;
  const std::string& original_;
  const std::string& name_;
  WordReader words_;
  std::size_t word_ = 0;
  std::array<std::vector<vec3>, 3> values_;
  std::array<Reference, 3> largest_{};
  std::size_t triangles_ = 0;
  bool names_materials_ = false;
  std::vector<std::string> names_{""};  // of materials
  std::vector<std::uint32_t> name_of_part_{0};
  std::vector<std::size_t> part_starts_{0};
};

// A stream over bytes that live elsewhere.
class ViewBuffer : public std::streambuf {
 public:
  explicit ViewBuffer(std::string& bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }
};

// One vertex per distinct triple. Vertices that share a position are chained, as there are few of each.
class VertexTable {
 public:
  VertexTable(const Checker& text, TriangleMesh& mesh) : text_(text), mesh_(mesh), first_(text.positions().size(), no_vertex) {}

  std::uint32_t vertex(const tinyobj::index_t& corner) {
    std::uint32_t* link = &first_[static_cast<std::size_t>(corner.vertex_index)];
    for (; *link != no_vertex; link = &next_[*link])
      if (corners_[*link].texcoord_index == corner.texcoord_index && corners_[*link].normal_index == corner.normal_index)
        return *link;
    const auto added = static_cast<std::uint32_t>(corners_.size());
    *link = added;
    corners_.push_back(corner);
    next_.push_back(no_vertex);
    append(corner);
    return added;
  }

 private:
  static constexpr std::uint32_t no_vertex = 0xffffffffu;

  void append(const tinyobj::index_t& corner) {
    const auto at = [](const std::vector<vec3>& values, int index) {
      return index < 0 ? vec3(0) : values[static_cast<std::size_t>(index)];
    };
    mesh_.positions.push_back(at(text_.positions(), corner.vertex_index));
    if (!text_.normals().empty()) mesh_.normals.push_back(at(text_.normals(), corner.normal_index));
    if (!text_.uvs().empty()) mesh_.uvs.emplace_back(at(text_.uvs(), corner.texcoord_index));
  }

  const Checker& text_;
  TriangleMesh& mesh_;
  std::vector<std::uint32_t> first_, next_;
  std::vector<tinyobj::index_t> corners_;
};

// Vertices of the same place, normal and texture coordinates are one.
class EqualVertices {
 public:
  explicit EqualVertices(const Checker& text) : text_(text) {}

  void begin(TriangleMesh& mesh) {
    mesh_ = &mesh;
    vertices_.clear();
  }
  std::uint32_t vertex(const tinyobj::index_t& corner) {
    const auto at = [](const std::vector<vec3>& values, int index) {
      return index < 0 ? vec3(0) : values[static_cast<std::size_t>(index)];
    };
    const vec3 p = at(text_.positions(), corner.vertex_index), n = at(text_.normals(), corner.normal_index);
    const vec2 uv(at(text_.uvs(), corner.texcoord_index));
    const auto [entry, is_new] =
        vertices_.try_emplace({p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y}, static_cast<std::uint32_t>(vertices_.size()));
    if (is_new) {
      mesh_->positions.push_back(p);
      mesh_->normals.push_back(n);
      mesh_->uvs.push_back(uv);
    }
    return entry->second;
  }

 private:
  const Checker& text_;
  TriangleMesh* mesh_ = nullptr;
  std::map<std::array<float, 8>, std::uint32_t> vertices_;
};

// Replaces each polygon of checked text by the triangles of its first corner with each edge.
std::string with_fans(const std::string& text) {
  std::string result;
  WordReader words(text);
  std::vector<std::string_view> corners;
  for (std::size_t begin = 0; !words.at_end(); begin = words.offset()) {
    const bool is_face = words.word() == "f";
    corners.clear();
    if (is_face)
      for (std::string_view word = words.word(); !word.empty(); word = words.word()) corners.push_back(word);
    words.next_line();
    if (corners.size() <= 3) {
      result += std::string_view(text).substr(begin, words.offset() - begin);
      continue;
    }
    for (std::size_t i = 2; i < corners.size(); ++i)
      result += fmt::format("f {} {} {}\n", corners[0], corners[i - 1], corners[i]);
  }
  return result;
}

// Calls `take(corners, part)` for each triangle.
template <class Take>
void load_triangles(std::string text, const std::string& name, const Take& take) {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  ViewBuffer buffer(text);
  std::istream stream(&buffer);
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream)) throw Error(Location{name}, error);
  for (const tinyobj::shape_t& shape : shapes) {
    const auto& corners = shape.mesh.indices;
    CHECK_EQ(corners.size() % 3, 0u);
    CHECK_EQ(corners.size() / 3, shape.mesh.smoothing_group_ids.size());
    for (std::size_t i = 0; i < corners.size(); i += 3) take(&corners[i], shape.mesh.smoothing_group_ids[i / 3]);
  }
}

void warn_of_left_out(const Checker& checker, std::size_t triangles, const std::string& name, TriangleMesh& mesh) {
  if (triangles == 0) throw Error(Location{name}, "no faces: every polygon is degenerate");
  if (triangles < checker.triangles())
    mesh.warnings.push_back(
        fmt::format("{}: {} triangles of degenerate polygons were left out", name, checker.triangles() - triangles));
}

}  // namespace

TriangleMesh parse_obj(std::string text, const std::string& name, Polygons polygons) {
  const std::string original = text;
  join_lines(text);
  Checker checker(text, original, name);
  checker.check();
  TriangleMesh mesh;
  mesh.triangles.reserve(checker.triangles());
  VertexTable table(checker, mesh);
  if (polygons == Polygons::fans) text = with_fans(text);
  load_triangles(std::move(text), name, [&](const tinyobj::index_t* corners, unsigned) {
    const std::uint32_t a = table.vertex(corners[0]), b = table.vertex(corners[1]);
    mesh.triangles.emplace_back(a, b, table.vertex(corners[2]));
  });
  warn_of_left_out(checker, mesh.triangles.size(), name, mesh);
  mesh.names_materials = checker.names_materials();
  mend_attributes(mesh, name);
  return mesh;
}

std::vector<ObjPart> parse_obj_parts(std::string text, const std::string& name, bool apart) {
  const std::string original = text;
  join_lines(text);
  Checker checker(text, original, name);
  checker.check();
  std::vector<ObjPart> parts;
  EqualVertices vertices(checker);
  std::optional<unsigned> current;
  bool has_normals = false, has_uvs = false;
  std::size_t triangles = 0;
  const auto end_part = [&] {
    if (!has_normals) parts.back().mesh.normals.clear();
    if (!has_uvs) parts.back().mesh.uvs.clear();
    mend_attributes(parts.back().mesh, name);
    has_normals = has_uvs = false;
  };
  text = with_fans(apart ? checker.text_with_part_numbers() : text);
  load_triangles(std::move(text), name, [&](const tinyobj::index_t* corners, unsigned part) {
    if (current != part) {
      if (current) end_part();
      current = part;
      parts.push_back({apart ? checker.material_of(part) : checker.last_material(), {}});
      vertices.begin(parts.back().mesh);
    }
    uvec3 triangle;
    for (int i = 0; i < 3; ++i) {
      triangle[i] = vertices.vertex(corners[i]);
      has_normals |= corners[i].normal_index >= 0;
      has_uvs |= corners[i].texcoord_index >= 0;
    }
    parts.back().mesh.triangles.push_back(triangle);
    ++triangles;
  });
  if (parts.empty()) parts.emplace_back();
  end_part();
  warn_of_left_out(checker, triangles, name, parts.front().mesh);
  parts.front().mesh.names_materials = checker.names_materials();
  return parts;
}

TriangleMesh read_obj(const std::string& path) { return parse_obj(read_file(path), path); }

}  // namespace etendue
