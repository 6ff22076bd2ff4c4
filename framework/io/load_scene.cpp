#include "framework/io/load_scene.h"

#include "framework/io/mesh_scene.h"
#include "framework/io/obj.h"
#include "framework/io/pbrt.h"
#include "framework/io/ply.h"
#include "framework/io/smf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace etendue {

namespace {

constexpr std::string_view builtin_prefix = "builtin:";

Scene make_builtin(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) {
    names.push_back(std::string(builtin_prefix) + scene.name);
    if (names.back() == name) return scene.make();
  }
  throw Error(where, unknown_name("scene", name, names));
}

Scene load_file(const std::string& path, const Location& where) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!std::filesystem::exists(path)) throw Error(where, fmt::format("no such scene file: '{}'", path));
  if (extension == ".pbrt") return read_pbrt(path);
  if (extension == ".obj") return mesh_scene(read_obj(path), path);
  if (extension == ".smf") return mesh_scene(read_smf(path), path);
  if (extension == ".ply") return mesh_scene(read_ply(path), path);
  throw Error(where,
              fmt::format("'{}' is no scene: expected builtin:NAME, or a file that ends in .pbrt, .obj, .smf or .ply", path));
}

}  // namespace

Scene load_scene(const std::string& name, const Location& where) {
  Scene scene = name.starts_with(builtin_prefix) ? make_builtin(name, where) : load_file(name, where);
  scene.name = name;
  return scene;
}

}  // namespace etendue
