// The rows of the table of built-in scenes, one family a file: parameters stand beside what they make.
#pragma once

#include "framework/io/load_scene.h"

#include <vector>

namespace etendue {

template <class Params>
Params params_of(Scene (*make)(const Params&));

// The row of a scene with parameters, by what makes it.
template <auto make>
BuiltinScene with_params(const char* name, const char* summary) {
  return scene_with_params<decltype(params_of(make)), make>(builtin_prefix, name, summary);
}

std::vector<BuiltinScene> room_scenes();
std::vector<BuiltinScene> many_light_scenes();
std::vector<BuiltinScene> mesh_scenes();
std::vector<BuiltinScene> stadium_scenes();
std::vector<BuiltinScene> exact_scenes();
std::vector<BuiltinScene> cavity_scenes();
std::vector<BuiltinScene> specular_scenes();
std::vector<BuiltinScene> border_scenes();
std::vector<BuiltinScene> occluder_scenes();
std::vector<BuiltinScene> glowing_room_scenes();
std::vector<BuiltinScene> sunlit_scenes();
std::vector<BuiltinScene> lamp_scenes();
std::vector<BuiltinScene> glossy_scenes();
std::vector<BuiltinScene> heap_scenes();

}  // namespace etendue
