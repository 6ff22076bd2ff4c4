// The way in which next-event estimation chooses one of several lights: a parameter of every method that samples lights.
#pragma once

#include "framework/core/params.h"

namespace etendue {

// by_need: a tree where it tells a scene's lights apart and pays for itself, else by power (LightSampler::needed_choice).
enum class LightChoice : std::uint8_t { by_need, power, uniform, tree };
constexpr auto names_of(LightChoice) { return std::array{"auto", "power", "uniform", "tree"}; }

template <class Visitor>
void describe_lights(Visitor& v, LightChoice& lights) {
  v.choice(
      "lights", lights,
      "how light samples choose among lights: by power, all alike, or by a tree over what each may send to the point; "
      "auto: the tree from 9 lights on that are not at infinity, from 3 unless all are triangles (from 2 where light samples "
      "alone find them); in path if they are small beside the scene");
}

}  // namespace etendue
