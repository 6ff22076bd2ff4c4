// The features that a scene needs, computed once. All code consults them, so that a scene pays only for what it contains.
#pragma once

#include "framework/scene/scene.h"

#include <string>
#include <vector>

namespace etendue {

struct SceneNeeds {
  bool caustic_map = false;  // a surface with a delta lobe that light can reach
  bool two_levels = false;   // instances
  bool quadrics = false;     // a leaf that tests more than triangles
  bool planes = false;
  bool light_choice = false;  // more than one light
  bool textures = false;
  bool masks = false;          // surfaces that let some rays through
  bool passed_lights = false;  // some of them emit
  bool shading_normals = false;
  bool environment = false;
  bool thin_lens = false;
  bool glossy = false;  // a non-delta lobe that is not diffuse

  struct Line {
    std::string what;
    bool needed;
    std::string why;
  };
  std::vector<Line> lines(const Scene& scene) const;  // for `etendue inspect`
};

SceneNeeds scene_needs(const Scene& scene);

}  // namespace etendue
