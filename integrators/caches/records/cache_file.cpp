#include "integrators/caches/records/cache_file.h"

#include "integrators/paths/path.h"

#include <etendue_build.h>
#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <cstdlib>

namespace etendue {

namespace {

constexpr std::string_view magic = "etncache";
constexpr std::uint32_t format = 4;
constexpr std::size_t prologue_bytes = magic.size() + sizeof(std::uint32_t) + 2 * sizeof(std::uint64_t);

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

}  // namespace

void ByteReader::refuse(const std::string& what) const { throw Error(where_, "this cache is damaged: " + what); }

void refuse_signed_filter(const RenderContext& context, const ByteReader& body) {
  if (has_signed_filter(context))
    throw Error(body.where(),
                "this cache goes on in the middle of its pixels' samples, which a filter with negative parts cannot; "
                "expected another --pixel-filter than mitchell, sinc and their kin");
}

std::string_view ByteReader::take_bytes(std::size_t count) {
  if (count > left_.size()) refuse(fmt::format("{} bytes expected where {} are left", count, left_.size()));
  const std::string_view taken = left_.substr(0, count);
  left_.remove_prefix(count);
  return taken;
}

void ByteReader::take(std::string& text) { text = take_bytes(take<std::uint32_t>()); }

std::size_t ByteReader::take_count(std::size_t element_bytes) {
  const auto count = take<std::uint64_t>();
  if (count > left_.size() / element_bytes)
    refuse(fmt::format("{} elements of {} bytes expected where {} bytes are left", count, element_bytes, left_.size()));
  return static_cast<std::size_t>(count);
}

void ParamTextVisitor::number(const char* name, float& value, double, double, const char*, const char*) {
  texts[name] = fmt::format("{}", value);
}

std::string make_cache_file(const CacheKey& key, std::string_view body) {
  ByteWriter rest;
  rest.add(std::string_view(ETENDUE_VERSION));
  rest.add(std::string_view(key.integrator));
  rest.add(key.format);
  rest.add(key.scene_hash);
  rest.add(std::string_view(key.scene));
  rest.add(static_cast<std::uint32_t>(key.params.size()));
  for (const auto& [name, value] : key.params) {
    rest.add(std::string_view(name));
    rest.add(std::string_view(value));
  }
  rest.bytes.append(body);

  ByteWriter file;
  file.bytes = magic;
  file.add(format);
  file.add(static_cast<std::uint64_t>(prologue_bytes + rest.bytes.size()));
  file.add(checksum(rest.bytes));
  return file.bytes + rest.bytes;
}

CacheFile open_cache_file(std::string_view bytes, const Location& where) {
  if (!bytes.starts_with(magic)) throw Error(where, "not a cache; expected a file that --save-cache wrote");
  ByteReader in(bytes.substr(magic.size()), where);
  if (const auto found = in.take<std::uint32_t>(); found != format)
    throw Error(where, fmt::format("a cache of format {}; this program reads format {}", found, format));
  if (const auto size = in.take<std::uint64_t>(); size != bytes.size())
    in.refuse(fmt::format("{} bytes long; {} were written", bytes.size(), size));
  if (in.take<std::uint64_t>() != checksum(in.left())) in.refuse("its checksum differs");
  if (const auto version = in.take<std::string>(); version != ETENDUE_VERSION)
    throw Error(where, fmt::format("a cache of version '{}'; this program is version '{}'", version, ETENDUE_VERSION));

  CacheFile file;
  in.take(file.key.integrator);
  in.take(file.key.format);
  in.take(file.key.scene_hash);
  in.take(file.key.scene);
  for (auto left = in.take<std::uint32_t>(); left > 0; --left) {
    const auto name = in.take<std::string>();
    in.take(file.key.params[name]);
  }
  file.body = in.left();
  return file;
}

void check_cache_key(const CacheKey& found, const CacheKey& wanted, std::span<const std::string_view> free,
                     const Location& where) {
  if (found.integrator != wanted.integrator)
    throw Error(where, fmt::format("a cache of integrator '{}', not of '{}'", found.integrator, wanted.integrator));
  if (found.format != wanted.format)
    throw Error(where, fmt::format("a cache of integrator '{}' in its format {}; this program reads its format {}",
                                   found.integrator, found.format, wanted.format));
  if (found.scene_hash != wanted.scene_hash)
    throw Error(where, fmt::format("made for another scene: geometry, materials and lights of '{}' ({:016x}) are not those of "
                                   "'{}' ({:016x})",
                                   found.scene, found.scene_hash, wanted.scene, wanted.scene_hash));
  for (const auto& [name, value] : wanted.params) {
    if (std::find(free.begin(), free.end(), name) != free.end()) continue;
    const auto other = found.params.find(name);
    if (other == found.params.end()) throw Error(where, fmt::format("made without the parameter '{}'", name));
    if (other->second != value) throw Error(where, fmt::format("made with {}={}, not with {}", name, other->second, value));
  }
}

CacheKey FileCache::key(const RenderContext& context, const Identity& identity) {
  CacheKey key{identity.integrator, context.scene.content_hash(), context.scene.name, identity.params, identity.format};
  std::string& depth = key.params.at("max_depth");
  depth = std::to_string(context.max_depth(std::atoi(depth.c_str())));
  return key;
}

std::string FileCache::save(const RenderContext& context) const {
  ByteWriter body;
  write(body);
  return make_cache_file(key(context, identity()), body.bytes);
}

void FileCache::load(const RenderContext& context, std::string_view bytes, const Location& where) {
  const CacheFile file = open_cache_file(bytes, where);
  Identity own = identity();
  CausticMap* const map = caustic_map();
  const auto decided = file.key.params.find("caustic_map");
  const bool adopts = map && *map == CausticMap::where_needed && decided != file.key.params.end();
  if (adopts) own.params["caustic_map"] = decided->second;
  check_cache_key(file.key, key(context, own), own.free, where);
  if (adopts) {
    *map = decided->second == name_of(CausticMap::on) ? CausticMap::on : CausticMap::off;
    if (*map == CausticMap::off && own.params.at("caustic_photons") != "0")
      throw Error(where, "made without a caustic map, for which caustic_photons asks");
  }
  ByteReader body(file.body, where);
  read(context, body);
  if (!body.left().empty()) body.refuse("bytes are left over");
}

}  // namespace etendue
