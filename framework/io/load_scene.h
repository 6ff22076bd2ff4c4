// Scenes by name: "builtin:NAME" or "builtin:NAME?key=value,key=value", a .pbrt file, Mitsuba's .xml, or a bare mesh
// (.obj, .smf, .ply) with a default camera, light and material.
#pragma once

#include "framework/core/params.h"
#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <functional>
#include <span>
#include <string>

namespace etendue {

// Throws Error (file:line:col) on anything it cannot read in full. `where` is the place that named the scene.
Scene load_scene(const std::string& name, const Location& where = {"command line"}, const SceneReading& reading = {});

// Does a file describe a scene of its own, and not a part that other files include? A .pbrt file does that begins a world,
// and an .xml file of Mitsuba's that has a camera, or includes others.
bool is_scene_file(const std::string& path);

struct BuiltinScene {
  std::string name, summary;  // name without "builtin:"
  Scene (*make)();            // with its parameters' defaults
  // Empty where there are no parameters. Both throw Error on any that are wrong.
  std::vector<ParamInfo> params = {};
  std::function<void(const ParamMap&)> check = {};
  std::function<Scene(const ParamMap&)> make_with = {};
};
std::span<const BuiltinScene> builtin_scenes();

inline constexpr std::string_view builtin_prefix = "builtin:";
// A built-in scene's name, parameters included, without making it. Throws Error with the nearest names.
void check_builtin(const std::string& name, const Location& where);

// The same for scenes of another table, "PREFIX:NAME?key=value,…".
Scene make_scene_of(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                    const Location& where);
void check_scene_of(std::span<const BuiltinScene> table, std::string_view prefix, const std::string& name,
                    const Location& where);

// A row of such a table.
template <class Params, Scene (*make)(const Params&)>
BuiltinScene scene_with_params(std::string_view prefix, const char* name, const char* summary) {
  const std::string owner = std::string(prefix) + name;
  return {name,
          summary,
          [] { return make({}); },
          list_params<Params>(),
          [owner](const ParamMap& map) { read_params<Params>(map, owner); },
          [owner](const ParamMap& map) { return make(read_params<Params>(map, owner)); }};
}

}  // namespace etendue
