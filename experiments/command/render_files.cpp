#include "experiments/command/render_files.h"

#include "framework/integrator.h"
#include "framework/io/whole_file.h"
#include "integrators/caches/records/cache_file.h"
#include "integrators/registry.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

namespace etendue {

namespace {

constexpr std::size_t magic_bytes = 8;  // with which every cache file begins

template <class Has>
void require(const Method& integrator, const std::string& option, const char* lack, const Has& has) {
  const IntegratorEntry& asked = find_integrator(integrator.name, integrator.where);
  if (has(*asked.make(integrator.params))) return;
  // A method may have it with other parameters alone.
  const bool by_parameters = has(*asked.make({}));
  std::string names;
  for (const IntegratorEntry& entry : integrators())
    if (has(*entry.make({}))) names += (names.empty() ? "" : ", ") + entry.name;
  throw Error(Location{option},
              fmt::format("integrator '{}' {}; those that do{}: {}", by_parameters ? integrator.label() : integrator.name, lack,
                          by_parameters ? ", as they are by default" : "", names));
}

}  // namespace

void check_outputs(const std::vector<OutputFile>& outputs) {
  std::map<std::string, std::string> options;
  for (const auto& [option, path] : outputs) {
    const Location where{option + " " + path};
    const std::string target = check_writable(path, where);
    if (const auto [other, is_new] = options.emplace(target, option); !is_new)
      throw Error(where, fmt::format("the same file as that of {}; expected another", other->second));
  }
}

std::string read_cache_bytes(const std::string& path) {
  const Location where{path};
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(path, error);  // before it is opened: a FIFO would wait
  std::ifstream file;
  if (regular) file.open(path, std::ios::binary);
  if (!regular || !file) throw Error(where, "cannot be read; expected a file that --save-cache wrote");
  const std::string magic = make_cache_file({}, {}).substr(0, magic_bytes);
  std::string bytes(magic_bytes, '\0');
  if (!file.read(bytes.data(), magic_bytes) || bytes != magic)
    throw Error(where, "not a cache; expected a file that --save-cache wrote");
  bytes.append(std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{});
  if (file.bad()) throw Error(where, "cannot be read to its end");
  return bytes;
}

void complete_from_cache(std::string_view bytes, const std::string& path, Method& integrator) {
  const CacheKey key = open_cache_file(bytes, Location{path}).key;
  if (integrator.name.empty()) integrator = {key.integrator, integrator.params, {path}};
  const IntegratorEntry& entry = find_integrator(integrator.name, integrator.where);
  if (key.integrator != entry.name)
    throw Error(Location{path}, fmt::format("a cache of integrator '{}', not of '{}'", key.integrator, entry.name));
  for (const ParamInfo& info : entry.params) {
    if (info.name == "max_depth") continue;  // the scene's, where none is asked for: a view that states another shall be told
    const auto value = key.params.find(info.name);
    if (value != key.params.end() && value->second != info.default_value)
      integrator.params.try_emplace(info.name, parse_param_value(value->second, Location{path}));
  }
}

void require_savable(const Method& integrator, const std::string& option) {
  require(integrator, option, "keeps no cache that can be saved",
          [](Integrator& i) { return i.cache() && i.cache()->savable(); });
}

void require_cache(const Method& integrator, const std::string& option, const char* lacks) {
  require(integrator, option, lacks, [](Integrator& i) { return i.cache() != nullptr; });
}

}  // namespace etendue
