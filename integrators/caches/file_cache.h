// A cache that can be saved and loaded, whatever it holds: the key, the checks and the frame of the file (cache_file.h) are the
// same for all. A method adds the parameters that determine what its cache holds, and the bytes of its content.
#pragma once

#include "framework/integrator.h"
#include "integrators/caches/records/cache_file.h"

#include <string>
#include <string_view>
#include <vector>

namespace etendue {

class FileCache : public SavableCache {
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
  virtual void write(ByteWriter& body) const = 0;
  // Throws Error where the body holds what no cache of the scene can. Bytes that are left over are refused afterwards.
  virtual void read(const RenderContext& context, ByteReader& body) = 0;

 private:
  static CacheKey key(const RenderContext& context, const Identity& identity);
};

}  // namespace etendue
