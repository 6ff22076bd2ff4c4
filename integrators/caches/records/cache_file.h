// A cache on disk: what it was made of, and its records, for other views of the same scene.
//
// All numbers are little-endian; text is a u32 length and its bytes, without an end mark.
//
//   8 bytes   "etncache"
//   u32       format, 4
//   u64       bytes of the whole file
//   u64       XXH3 of all bytes that follow
//   text      version of the program
//   text      integrator
//   u32       format of its own part, raised when what that holds changes in form or meaning
//   u64       Scene::content_hash: geometry, materials and lights, not the camera
//   text      the scene's name, for people
//   u32       number of parameters; of each: text name, text value
//   rest      the integrator's own part: its records
//
// A file is refused, with the reason, when it is of another format or program version, cut short or damaged, or when it was
// made for another scene, by another integrator or another format of its part, or with other parameters that decide what a
// record holds. The checksum finds every flipped bit; even so, each length is checked against the bytes that are left before it
// is used.
#pragma once

#include "framework/integrator.h"
#include "integrators/photons/photon_maps.h"

#include <bit>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace etendue {

class ByteWriter {
 public:
  template <class T>
  void add(const T& value) {
    static_assert(std::endian::native == std::endian::little && std::is_arithmetic_v<T>);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const vec3& v) { add(v.x), add(v.y), add(v.z); }
  void add(const mat3& m) { add(m[0]), add(m[1]), add(m[2]); }
  void add(std::string_view text) { add(static_cast<std::uint32_t>(text.size())), bytes.append(text); }

  std::string bytes;
};

// Every `take` throws Error where fewer bytes are left than it needs.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, Location where) : left_(bytes), where_(std::move(where)) {}

  template <class T>
  void take(T& value) {
    static_assert(std::endian::native == std::endian::little && std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    std::memcpy(&value, take_bytes(sizeof value).data(), sizeof value);
  }
  void take(vec3& v) { take(v.x), take(v.y), take(v.z); }
  void take(mat3& m) { take(m[0]), take(m[1]), take(m[2]); }
  void take(std::string& text);
  template <class T>
  T take() {
    T value{};
    take(value);
    return value;
  }
  // A u64 count of elements of at least so many bytes each, all of which must be left.
  std::size_t take_count(std::size_t element_bytes);

  std::string_view left() const { return left_; }
  const Location& where() const { return where_; }
  [[noreturn]] void refuse(const std::string& what) const;  // as damaged

 private:
  std::string_view take_bytes(std::size_t count);

  std::string_view left_;
  Location where_;
};

// Throws Error where the pixel filter has negative parts. Call it for a cache that goes on in the middle of its pixels'
// samples: without the first ones these may weigh less than nothing.
void refuse_signed_filter(const RenderContext& context, const ByteReader& body);

using ParamTexts = std::map<std::string, std::string>;

// Writes every value as text that the command line reads back to the same bits.
class ParamTextVisitor : public Choices<ParamTextVisitor> {
 public:
  ParamTexts texts;

  void integer(const char* name, int& value, std::int64_t, std::int64_t, const char*, const char*) {
    texts[name] = std::to_string(value);
  }
  void number(const char* name, float& value, double, double, const char*, const char*);
  void flag(const char* name, bool& value, const char*) { texts[name] = value ? "true" : "false"; }
  void choose(const char* name, std::string& value, Names, const char*) { texts[name] = value; }
};

template <class Params>
ParamTexts param_texts(Params params) {
  ParamTextVisitor visitor;
  describe(visitor, params);
  return visitor.texts;
}

struct CacheKey {
  std::string integrator;
  std::uint64_t scene_hash = 0;
  std::string scene;  // its name, which is not compared
  ParamTexts params;
  std::uint32_t format = 1;  // of what the integrator holds
};

// A whole file.
std::string make_cache_file(const CacheKey& key, std::string_view body);

struct CacheFile {
  CacheKey key;
  std::string_view body;  // into the bytes that were given
};
// Throws Error where the bytes are not a whole file of this version.
CacheFile open_cache_file(std::string_view bytes, const Location& where);

// Throws Error unless the file was made for this key; parameters named in `free` may differ.
void check_cache_key(const CacheKey& found, const CacheKey& wanted, std::span<const std::string_view> free,
                     const Location& where);

// A cache that can be saved and loaded, whatever it holds: the key, the checks and the frame of the file are the same for all.
// A method adds the parameters that determine what its cache holds, and the bytes of its content.
class FileCache : public Cache {
 public:
  std::string save(const RenderContext& context) const final;
  void load(const RenderContext& context, std::string_view bytes, const Location& where) final;

 protected:
  struct Identity {
    std::string integrator;
    ParamTexts params;                   // max_depth among them; 0: the scene's, which counts then
    std::vector<std::string_view> free;  // parameters that may differ when it is loaded
    std::uint32_t format = 1;            // of the content: another one's files are refused
  };
  virtual Identity identity() const = 0;
  // The parameter that a method decides by itself where it is `auto`, and on which it depends what the cache holds. A loaded
  // cache takes it from the file. It is null where there is no such parameter, or records do not depend on it.
  virtual CausticMap* caustic_map() { return nullptr; }
  virtual void write(ByteWriter& body) const = 0;
  // Throws Error where the body holds what no cache of the scene can. Bytes that are left over are refused afterwards.
  virtual void read(const RenderContext& context, ByteReader& body) = 0;

 private:
  static CacheKey key(const RenderContext& context, const Identity& identity);
};

}  // namespace etendue
