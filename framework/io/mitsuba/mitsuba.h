// Scenes in Mitsuba's XML, versions 0.4 to 3.
//
// Both spellings of names are read (toWorld and to_world, lookAt and lookat). What is read of each element, and how, stands in
// docs/scene-files.md, which a test holds against mitsuba_support().
//
// What would change the image and cannot be represented is an error. Where SceneReading::approximate is set, the nearest thing
// is taken instead, and each such choice is named in Scene::warnings with its place and its effect.
//
// Units and conventions: Mitsuba's camera looks along +z with +x to the left of the image, and v = 0 is the top row of an
// image. Both are turned into this renderer's conventions here. The light of a spectrum is what Mitsuba's RGB modes make of it.
#pragma once

#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// Throws Error at `file:line:col`.
Scene read_mitsuba(const std::string& path, const SceneReading& reading = {});
// `path` names the text in messages and is where relative file names start from.
Scene parse_mitsuba(std::string text, const std::string& path, const SceneReading& reading = {});

// Says what the reader makes of an element with this type.
struct MitsubaSupport {
  std::string_view element, type, how;
};
std::vector<MitsubaSupport> mitsuba_support();

}  // namespace etendue
