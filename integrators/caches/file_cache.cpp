#include "integrators/caches/file_cache.h"

#include <cstdlib>

namespace etendue {

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
  const Identity own = identity();
  check_cache_key(file.key, key(context, own), own.free, where);
  ByteReader body(file.body, where);
  read(context, body);
  if (!body.left().empty()) body.refuse("bytes are left over");
}

}  // namespace etendue
