#include "experiments/command/render_cache.h"

#include "framework/integrator.h"
#include "integrators/cache_file.h"
#include "integrators/registry.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace etendue {

namespace {

template <class Has>
void require(const Method& integrator, const std::string& option, const char* lack, const Has& has) {
  if (has(*find_integrator(integrator.name, integrator.where).make(integrator.params))) return;
  std::string names;
  for (const IntegratorEntry& entry : integrators())
    if (has(*entry.make({}))) names += (names.empty() ? "" : ", ") + entry.name;
  throw Error(Location{option}, fmt::format("integrator '{}' {}; those that do: {}", integrator.name, lack, names));
}

}  // namespace

std::string read_cache_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path))
    throw Error(Location{path}, "cannot be read; expected a file that --save-cache wrote");
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw Error(Location{path}, "cannot be read to its end");
  return bytes;
}

void complete_from_cache(std::string_view bytes, const std::string& path, Method& integrator) {
  const CacheKey key = open_cache_file(bytes, Location{path}).key;
  if (integrator.name.empty()) integrator = {key.integrator, integrator.params, {path}};
  const IntegratorEntry& entry = find_integrator(integrator.name, integrator.where);
  if (key.integrator != entry.name)
    throw Error(Location{path}, fmt::format("a cache of integrator '{}', not of '{}'", key.integrator, entry.name));
  for (const ParamInfo& info : entry.params) {
    const auto value = key.params.find(info.name);
    if (value != key.params.end() && value->second != info.default_value)
      integrator.params.try_emplace(info.name, parse_param_value(value->second, Location{path}));
  }
}

void require_savable(const Method& integrator, const std::string& option) {
  require(integrator, option, "keeps no cache that can be saved", [](Integrator& i) { return i.savable_cache() != nullptr; });
}

void require_records(const Method& integrator, const std::string& option) {
  require(integrator, option, "has no records to show", [](Integrator& i) { return i.record_discs().has_value(); });
}

void require_standard_error(const Method& integrator, const std::string& option) {
  require(integrator, option, "does not estimate its own error", [](Integrator& i) { return i.standard_error().has_value(); });
}

void check_writable(const std::string& path, const std::string& option) {
  const auto parent = std::filesystem::path(path).parent_path();
  if (!parent.empty() && !std::filesystem::is_directory(parent))
    throw Error(Location{option + " " + path}, "no directory '" + parent.string() + "'; expected one that exists");
  const std::string partial = path + ".part";
  const bool writable = !std::filesystem::is_directory(path) && std::ofstream(partial).good();
  std::filesystem::remove(partial);
  if (!writable)
    throw Error(Location{option + " " + path}, "cannot be written; expected a file in a directory that can be written to");
}

void write_cache_bytes(const std::string& path, std::string_view bytes) {
  const std::string partial = path + ".part";
  std::ofstream file(partial, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file || std::rename(partial.c_str(), path.c_str()) != 0) {
    std::remove(partial.c_str());
    throw Error(Location{path}, "cannot write the cache; is the disk full?");
  }
}

}  // namespace etendue
