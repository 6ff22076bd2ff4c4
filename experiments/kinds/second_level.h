// A scene with a second level of structures, or without: its images differ by rounding at most.
#pragma once

#include "framework/scene/scene.h"

#include <optional>

namespace etendue {

// An instance of one small triangle joins the scene, a hundredth of its diagonal beneath it.
Scene with_second_level(const Scene& scene);

// All instances are written out into the world's own geometry, each with its own copy. nullopt where the scene holds quadrics,
// of which not every transform gives another.
std::optional<Scene> without_second_level(const Scene& scene);

}  // namespace etendue
