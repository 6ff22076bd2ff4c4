// Scenes written in the language of pbrt, as read_pbrt reads them: what is written renders the same image, and written again
// it is the same text and the same files. docs/scene-files.md states where rounding remains.
//
// The words are those of pbrt-v4. Where it has none and version 3 has (mirrors, tinted glass, equirectangular environments),
// version 3's are used, which read_pbrt understands beside the others. Each such thing, and all that neither version can say,
// is told in a warning.
#pragma once

#include "framework/scene/scene.h"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

struct PbrtText {
  std::string text;
  std::vector<std::string> warnings;  // each names what could not be said, what stands in its place and what that changes
};

// Takes the files that the text names, each by its name in the text: "FOLDER/mesh-0.ply", "FOLDER/texture-0.png" and the like.
using TakeFile = std::function<void(const std::string& name, std::string_view bytes)>;

PbrtText write_pbrt(const Scene& scene, const std::string& folder, const TakeFile& take);

}  // namespace etendue
