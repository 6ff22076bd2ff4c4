#include "framework/io/load_scene.h"

#include "framework/io/gzip.h"
#include "framework/io/mesh/mesh_scene.h"
#include "framework/io/mesh/obj.h"
#include "framework/io/mesh/ply.h"
#include "framework/io/mesh/smf.h"
#include "framework/io/mitsuba/mitsuba.h"
#include "framework/io/pbrt/pbrt.h"
#include "framework/io/text.h"
#include "framework/scene/precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace etendue {

namespace {

const BuiltinScene& find_named(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                               const Location& where) {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : table) {
    names.push_back(std::string(prefix) + scene.name);
    if (names.back() == name) return scene;
  }
  throw Error(where, unknown_name("scene", name, names));
}

// "1e4" is a whole number to a scene.
ParamValue parse_scene_param(const std::string& text, const Location& where) {
  ParamValue value = parse_param_value(text, where);
  if (const auto* number = std::get_if<double>(&value.value);
      number && *number == std::floor(*number) && std::abs(*number) < 9e15)
    value.value = static_cast<std::int64_t>(*number);
  return value;
}

struct NamedScene {
  const BuiltinScene& scene;
  ParamMap params;
};

NamedScene find_scene(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                      const Location& where) {
  const std::size_t question = name.find('?');
  const std::string plain = name.substr(0, question);
  NamedScene found{find_named(table, prefix, plain, where), {}};
  if (question == std::string::npos) return found;
  if (!found.scene.make_with)
    throw Error(where, fmt::format("'{}': {} has no parameters; expected nothing behind its name", name, plain));
  std::istringstream pairs(name.substr(question + 1));
  for (std::string pair; std::getline(pairs, pair, ',');) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos)
      throw Error(where, fmt::format("'{}': '{}': expected key=value, as in builtin:mesh?triangles=1e6", name, pair));
    const std::string key = pair.substr(0, equals);
    if (!found.params.emplace(key, parse_scene_param(pair.substr(equals + 1), where)).second)
      throw Error(where, fmt::format("'{}': {} is given twice", name, key));
  }
  return found;
}

Scene load_file(const std::string& path, const Location& where, const SceneReading& reading) {
  const std::string extension = extension_of(path);
  if (std::error_code ignored; !std::filesystem::exists(path, ignored)) {
    std::vector<std::string> names;
    for (const BuiltinScene& scene : builtin_scenes()) names.push_back(scene.name);
    const std::vector<std::string> near = nearest_names(path.substr(0, path.find('?')), names, 1);
    throw Error(where, fmt::format("no such scene file: '{}'{}", path,
                                   near.empty() ? "" : fmt::format("; did you mean 'builtin:{}'?", near.front())));
  }
  if (extension == ".pbrt") return read_pbrt(path, reading);
  if (extension == ".xml") return read_mitsuba(path, reading);
  if (extension == ".obj") return mesh_scene(read_obj(path), path);
  if (extension == ".smf") return mesh_scene(read_smf(path), path);
  if (extension == ".ply") return mesh_scene(read_ply(path), path);
  throw Error(
      where,
      fmt::format("'{}' is no scene: expected builtin:NAME, or a file that ends in .pbrt, .xml, .obj, .smf or .ply", path));
}

}  // namespace

bool is_scene_file(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension != ".pbrt" && extension != ".xml") return false;
  const std::string text = read_file(path);
  const auto has = [&](std::string_view word) { return text.find(word) != std::string::npos; };
  return extension == ".pbrt" ? has("WorldBegin") : has("<scene") && (has("<sensor") || has("<camera") || has("<include"));
}

void check_scene_of(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                    const Location& where) {
  const NamedScene found = find_scene(table, prefix, name, where);
  if (!found.params.empty()) found.scene.check(found.params);
}

Scene make_scene_of(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                    const Location& where) {
  const NamedScene found = find_scene(table, prefix, name, where);
  return found.params.empty() ? found.scene.make() : found.scene.make_with(found.params);
}

void check_builtin(const std::string& name, const Location& where) {
  check_scene_of(builtin_scenes(), builtin_prefix, name, where);
}

Scene load_scene(const std::string& name, const Location& where, const SceneReading& reading) {
  Scene scene = name.starts_with(builtin_prefix) ? make_scene_of(builtin_scenes(), builtin_prefix, name, where)
                                                 : load_file(name, where, reading);
  scene.name = name;
  if (!reading.pixel_filter.empty()) {
    scene.filter = make_pixel_filter(named_filter(reading.pixel_filter));
    for (NamedCamera& camera : scene.cameras) camera.filter = scene.filter;
  }
  for (const std::string& warning : precision_warnings(scene)) scene.warnings.push_back(name + ": " + warning);
  return scene;
}

}  // namespace etendue
