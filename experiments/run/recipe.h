// The recipe of an image, as it stands in the attributes of its EXR file, and back: enough to make the same bits again.
//
//   etendue_scene, etendue_scene_hash        as typed; of all that changes an image
//   etendue_integrator, etendue_accel        "path max_depth=0 mis=power": every parameter, those at their default too
//   etendue_seed, etendue_resolution         "640x480"
//   etendue_iterations, etendue_budget       how many it has, and what ended it
//   etendue_version, etendue_commit, etendue_manifest
//   etendue_camera, etendue_pixel_filter     where a render was told to take others than the scene's
//   etendue_window                           "8x0 16x16": the pixels that an image shows of one of that resolution
//   etendue_cache, etendue_states_error      where a render began with a saved cache (XXH3 of it), or its error was asked for
#pragma once

#include "experiments/config/method.h"
#include "experiments/log/log.h"
#include "framework/core/parallel.h"
#include "framework/core/vec.h"

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace etendue {

struct Recipe {
  std::string scene;
  std::uint64_t scene_hash = 0;
  Method integrator, accel;
  std::uint64_t seed = 1;
  ivec2 resolution{0};
  std::uint64_t iterations = 0;
  std::string budget;
  std::string cache = {};  // hash of the one it began with
  bool states_error = false;
  std::string camera = {}, pixel_filter = {};  // as typed in the place of the scene's
  Tile window = {};                            // the part of the image that it shows; empty: all
  std::string commit = {};                     // of the program that made it; read_recipe fills it
};

// Writes the method with every parameter: "path max_depth=0 mis=power".
std::string resolved_integrator(const Method& integrator);
std::string resolved_accel(const Method& accel);

// Both sides of "640x480", which are above zero; nullopt where it is something else.
std::optional<ivec2> parse_resolution(std::string_view text);

std::map<std::string, std::string> recipe_attributes(const Recipe& recipe, ManifestRecord manifest);
// Reads the recipe of the image at `path`. Throws Error where it has none, or where a method or a parameter is not known.
Recipe read_recipe(const std::map<std::string, std::string>& attributes, const std::string& path);

}  // namespace etendue
