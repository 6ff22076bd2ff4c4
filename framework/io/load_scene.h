// Scenes by name: "builtin:NAME", a .pbrt file, or a bare mesh (.obj, .smf, .ply) with a default camera, light and material.
#pragma once

#include "framework/core/error.h"
#include "framework/scene/scene.h"

#include <span>
#include <string>

namespace etendue {

// Throws Error (file:line:col) on anything it cannot read in full. `where` is the place that named the scene.
Scene load_scene(const std::string& name, const Location& where = {"command line"});

struct BuiltinScene {
  std::string name, summary;  // name without "builtin:"
  Scene (*make)();
};
std::span<const BuiltinScene> builtin_scenes();

}  // namespace etendue
