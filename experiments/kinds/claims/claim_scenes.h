// Scenes like those of the claims' sources, in addition to the built-in ones: "claim:NAME?key=value,…".
#pragma once

#include "framework/io/load_scene.h"

namespace etendue {

std::span<const BuiltinScene> claim_scenes();  // named without "claim:"

// Any name load_scene takes, or one of the above. Both throw Error.
Scene load_claim_scene(const std::string& name, const SceneReading& reading = {});
void check_claim_scene(const std::string& name, const Location& where);

}  // namespace etendue
