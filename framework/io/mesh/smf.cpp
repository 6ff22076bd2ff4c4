#include "framework/io/mesh/smf.h"

#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace etendue {

namespace {

class SmfReader {
 public:
  SmfReader(std::string_view text, const std::string& name) : text_(text), name_(name), words_(text) {}

  TriangleMesh read() {
    for (; !words_.at_end(); words_.next_line()) read_line();
    if (blocks_.size() > 1) fail("the file ends inside a begin block");
    if (mesh_.triangles.empty()) throw Error(Location{name_}, "no faces");
    for (const Face& face : faces_) check(face);
    warn_of_concave_fans(mesh_, fans_, name_);
    return std::move(mesh_);
  }

 private:
  // Vertices may follow the faces that use them, so the upper bound is checked at the end.
  struct Face {
    std::int64_t largest;
    std::size_t offset;
  };

  std::string_view next() {
    const std::string_view word = words_.word();
    word_ = words_.offset() - word.size();
    return word.starts_with('#') ? std::string_view() : word;
  }
  [[noreturn]] void fail(const std::string& what) const { throw Error(location_at(name_, text_, word_), what); }

  // A file without a vertex may be no mesh, so nothing of it is shown.
  std::string found(std::string_view word) const { return mesh_.positions.empty() ? "" : ", found " + quote(word); }

  void read_line() {
    static const std::vector<std::string> known{"v", "f", "begin", "end", "bind", "n", "c", "r", "tex"};
    constexpr std::array<std::string_view, 6> transforms{"trans", "scale", "rot", "mmult", "mload", "set"};
    constexpr std::array<std::string_view, 5> attributes{"bind", "n", "c", "r", "tex"};
    const auto in = [](const auto& list, std::string_view word) {
      return std::find(list.begin(), list.end(), word) != list.end();
    };

    const std::string_view keyword = next();
    if (keyword.empty() || in(attributes, keyword)) return;
    if (keyword == "v") {
      read_vertex();
    } else if (keyword == "f") {
      read_face();
    } else if (keyword == "begin") {
      blocks_.push_back(vertex_count());
    } else if (keyword == "end") {
      if (blocks_.size() == 1) fail("'end' without 'begin'");
      blocks_.pop_back();
    } else if (in(transforms, keyword)) {
      fail(fmt::format("'{}' is not supported: apply it to the vertices", keyword));
    } else {
      if (mesh_.positions.empty()) fail("no SMF file: expected v, f, begin or another of its keywords");
      fail(unknown_name("keyword", keyword, known));
    }
  }

  void read_vertex() {
    vec3 p;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next();
      const auto number = parse_number(word);
      if (!number) fail(word.empty() ? std::string("expected 3 numbers after 'v'") : "expected a number" + found(word));
      p[i] = static_cast<float>(*number);
    }
    if (const std::string_view word = next(); !word.empty()) fail("expected 3 numbers after 'v'" + found(word));
    mesh_.positions.push_back(p);
  }

  void read_face() {
    const std::size_t begin = word_, before = mesh_.triangles.size();
    std::int64_t largest = 0;
    std::uint32_t first = 0, previous = 0;
    std::size_t corners = 0;
    for (std::string_view word = next(); !word.empty(); word = next(), ++corners) {
      const std::int64_t index = read_index(word);
      largest = std::max(largest, index);
      const auto vertex = static_cast<std::uint32_t>(index);
      if (corners == 0) first = vertex;
      if (corners >= 2) mesh_.triangles.emplace_back(first, previous, vertex);
      previous = vertex;
    }
    if (corners < 3) fail(fmt::format("a face needs 3 vertices or more, found {}", corners));
    if (corners > 3) fans_.push_back({before, corners - 2});
    if (largest >= vertex_count()) faces_.push_back({largest, begin});
  }

  // Zero-based, over the whole file.
  std::int64_t read_index(std::string_view word) const {
    std::int64_t index = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error != std::errc() || stop != word.data() + word.size()) fail("expected the index of a vertex" + found(word));
    if (index == 0 || index < -vertex_count() || index > 0x7fffffff)
      fail(fmt::format("vertex {}, but there are {} so far (indices count from 1, or back from -1)", index, vertex_count()));
    return index < 0 ? vertex_count() + index : blocks_.back() + index - 1;
  }

  void check(const Face& face) const {
    if (face.largest < vertex_count()) return;
    throw Error(location_at(name_, text_, face.offset),
                fmt::format("a face refers to vertex {}, but the file has {}", face.largest + 1, vertex_count()));
  }

  std::int64_t vertex_count() const { return static_cast<std::int64_t>(mesh_.positions.size()); }

  std::string_view text_;
  const std::string& name_;
  WordReader words_;
  std::size_t word_ = 0;
  std::vector<std::int64_t> blocks_{0};  // vertices before each open block
  std::vector<Face> faces_;              // that used vertices not yet read
  std::vector<Fan> fans_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh parse_smf(std::string_view text, const std::string& name) { return SmfReader(text, name).read(); }

TriangleMesh read_smf(const std::string& path) { return parse_smf(read_file(path), path); }

}  // namespace etendue
