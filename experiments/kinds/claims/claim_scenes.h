// Scenes like those of the claims' sources, in addition to the built-in ones: "claim:NAME?key=value,…".
#pragma once

#include "framework/core/params.h"
#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <functional>
#include <span>

namespace etendue {

struct ClaimScene {
  std::string name, summary;  // name without "claim:"
  std::vector<ParamInfo> params;
  // Both take its whole name and what stands behind the question mark, and throw Error on parameters that are wrong.
  std::function<void(const std::string&, const ParamMap&)> check;
  std::function<Scene(const std::string&, const ParamMap&)> make;
};
std::span<const ClaimScene> claim_scenes();

// Any name load_scene takes, or one of the above. Both throw Error.
Scene load_claim_scene(const std::string& name, const SceneReading& reading = {});
void check_claim_scene(const std::string& name, const Location& where);

}  // namespace etendue
