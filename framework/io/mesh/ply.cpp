#include "framework/io/mesh/ply.h"

#include "framework/io/mesh/ply_header.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace etendue {

using namespace ply;

namespace {

// Values of an ascii body. NaN and infinity are read, as some exporters write them into normals.
class AsciiSource {
 public:
  AsciiSource(std::string_view bytes, std::size_t body, const std::string& name)
      : bytes_(bytes), name_(name), words_(bytes.substr(body)), body_(body) {}

  double read(Scalar) {
    const std::string_view word = words_.word_on_any_line();
    word_ = body_ + words_.offset() - word.size();
    if (word.empty()) fail("the file ends before its data does");
    if (const auto number = parse_number(word)) return *number;
    const std::string_view magnitude = word.substr(word.front() == '-' || word.front() == '+');
    if (magnitude == "nan" || magnitude == "inf" || magnitude == "NaN" || magnitude == "Inf") return infinity;
    fail(fmt::format("expected a number, found {}", quote(word)));
  }
  // The least room a row can take, and the room there is.
  static std::uint64_t least_bytes(const Property&) { return 2; }
  std::uint64_t remaining() const { return bytes_.size() - body_ - words_.offset() + 1; }
  void expect_end() {
    const std::string_view word = words_.word_on_any_line();
    word_ = body_ + words_.offset() - word.size();
    if (!word.empty()) fail(fmt::format("{} follows the data that the header announces", quote(word)));
  }
  [[noreturn]] void fail(const std::string& what) const { throw Error(location_at(name_, bytes_, word_), what); }

 private:
  std::string_view bytes_;
  const std::string& name_;
  WordReader words_;
  std::size_t body_, word_ = 0;
};

template <bool big_endian>
class BinarySource {
 public:
  BinarySource(std::string_view bytes, std::size_t body, const std::string& name)
      : bytes_(bytes), position_(body), name_(name) {}

  double read(Scalar type) {
    if (remaining() < size_of(type)) fail("the file ends before its data does");
    last_ = position_;
    switch (type) {
      case Scalar::i8:
        return load<std::int8_t, std::uint8_t>();
      case Scalar::u8:
        return load<std::uint8_t, std::uint8_t>();
      case Scalar::i16:
        return load<std::int16_t, std::uint16_t>();
      case Scalar::u16:
        return load<std::uint16_t, std::uint16_t>();
      case Scalar::i32:
        return load<std::int32_t, std::uint32_t>();
      case Scalar::u32:
        return load<std::uint32_t, std::uint32_t>();
      case Scalar::f32:
        return load<float, std::uint32_t>();
      case Scalar::f64:
        return load<double, std::uint64_t>();
    }
    fail("unreachable");
  }
  static std::uint64_t least_bytes(const Property& p) { return size_of(p.is_list ? p.count_type : p.type); }
  std::uint64_t remaining() const { return bytes_.size() - position_; }
  // Line ends and padding are forgiven.
  void expect_end() {
    last_ = position_;
    for (; position_ < bytes_.size(); ++position_)
      if (!std::strchr(" \t\r\n", bytes_[position_]))  // finds 0 as well
        fail(fmt::format("{} bytes follow the data that the header announces", bytes_.size() - last_));
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(Location{fmt::format("{}: byte {}", name_, last_)}, what);
  }

 private:
  template <class Value, class Bits>
  double load() {
    Bits bits;
    std::memcpy(&bits, bytes_.data() + position_, sizeof bits);
    position_ += sizeof bits;
    if constexpr ((std::endian::native == std::endian::big) != big_endian) {
      if constexpr (sizeof bits == 2) bits = __builtin_bswap16(bits);
      if constexpr (sizeof bits == 4) bits = __builtin_bswap32(bits);
      if constexpr (sizeof bits == 8) bits = __builtin_bswap64(bits);
    }
    return static_cast<double>(std::bit_cast<Value>(bits));
  }

  std::string_view bytes_;
  std::size_t position_, last_ = 0;
  const std::string& name_;
};

// The body, element by element in the header's order.
template <class Source>
class BodyReader {
 public:
  BodyReader(const Header& header, Source source, const std::string& name) : header_(header), source_(source), name_(name) {}

  TriangleMesh read() {
    for (const Element& element : header_.elements) {
      std::uint64_t row = 0;
      for (const Property& property : element.properties) row += Source::least_bytes(property);
      if (row > 0 && element.count > source_.remaining() / row)
        source_.fail(fmt::format("the header announces {} rows of element {}, which do not fit into the {} bytes that are left",
                                 element.count, quote(element.name), source_.remaining()));
      if (element.name == "vertex")
        read_vertices(element);
      else if (element.name == "face")
        read_faces(element);
      else if (row > 0)
        skip(element);
    }
    source_.expect_end();
    if (mesh_.triangles.empty()) throw Error(Location{name_}, "no faces: each has less than three vertices");
    warn_of_concave_fans(mesh_, fans_, name_);
    if (left_out_ > 0)
      mesh_.warnings.push_back(fmt::format("{}: {} faces of less than three vertices were left out", name_, left_out_));
    return std::move(mesh_);
  }

 private:
  void read_vertices(const Element& element) {
    bool has[slot_count] = {};
    for (const Property& p : element.properties)
      if (p.slot != no_slot) has[p.slot] = true;
    const bool normals = has[3] && has[4] && has[5], uvs = has[6] && has[7];
    mesh_.positions.reserve(element.count);
    if (normals) mesh_.normals.reserve(element.count);
    if (uvs) mesh_.uvs.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      float value[slot_count] = {};
      for (const Property& p : element.properties) {
        if (p.slot == no_slot) {
          skip(p);
          continue;
        }
        value[p.slot] = static_cast<float>(source_.read(p.type));
        if (p.slot < 3 && !std::isfinite(value[p.slot]))
          source_.fail(fmt::format("coordinate {} of vertex {} is not finite", p.name, i));
      }
      mesh_.positions.emplace_back(value[0], value[1], value[2]);
      if (normals) mesh_.normals.emplace_back(value[3], value[4], value[5]);
      if (uvs) mesh_.uvs.emplace_back(value[6], value[7]);
    }
  }

  void read_faces(const Element& element) {
    mesh_.triangles.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const Property& p : element.properties) p.is_indices ? read_polygon(p, i) : skip(p);
  }

  void read_polygon(const Property& p, std::uint64_t face) {
    const std::uint64_t count = read_count(p);
    if (count < 3) ++left_out_;
    if (count == 4) mesh_.quads.push_back(static_cast<std::uint32_t>(mesh_.triangles.size()));
    if (count > 4) fans_.push_back({mesh_.triangles.size(), static_cast<std::size_t>(count - 2)});
    std::uint32_t first = 0, previous = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const double index = source_.read(p.type);
      if (!(index >= 0 && index < static_cast<double>(vertex_count())) || index != std::floor(index))
        source_.fail(fmt::format("face {} refers to vertex {}, but there are {}", face, index, vertex_count()));
      const auto vertex = static_cast<std::uint32_t>(index);
      if (i == 0) first = vertex;
      if (i >= 2) mesh_.triangles.emplace_back(first, previous, vertex);
      previous = vertex;
    }
  }

  std::uint64_t vertex_count() const {
    for (const Element& element : header_.elements)
      if (element.name == "vertex") return element.count;
    return 0;
  }

  std::uint64_t read_count(const Property& p) {
    const double count = source_.read(p.count_type);
    Property item = p;
    item.is_list = false;
    if (count < 0 || count != std::floor(count) || count > static_cast<double>(source_.remaining() / Source::least_bytes(item)))
      source_.fail(fmt::format("a list of {} values of property {} does not fit into the {} bytes that are left", count,
                               quote(p.name), source_.remaining()));
    return static_cast<std::uint64_t>(count);
  }

  void skip(const Property& p) {
    if (!p.is_list) {
      source_.read(p.type);
      return;
    }
    for (std::uint64_t n = read_count(p); n > 0; --n) source_.read(p.type);
  }
  void skip(const Element& element) {
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const Property& p : element.properties) skip(p);
  }

  const Header& header_;
  Source source_;
  const std::string& name_;
  TriangleMesh mesh_;
  std::vector<Fan> fans_;
  std::uint64_t left_out_ = 0;  // faces
};

}  // namespace

TriangleMesh parse_ply(std::string_view bytes, const std::string& name) {
  const Header header = read_header(bytes, name);
  TriangleMesh mesh;
  if (header.format == Format::ascii)
    mesh = BodyReader(header, AsciiSource(bytes, header.body, name), name).read();
  else if (header.format == Format::little)
    mesh = BodyReader(header, BinarySource<false>(bytes, header.body, name), name).read();
  else
    mesh = BodyReader(header, BinarySource<true>(bytes, header.body, name), name).read();
  mend_attributes(mesh, name);
  return mesh;
}

TriangleMesh read_ply(const std::string& path) { return parse_ply(read_file(path), path); }

}  // namespace etendue
