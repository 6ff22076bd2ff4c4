#include "framework/scenes/builtin_scenes.h"

namespace etendue {

std::span<const BuiltinScene> builtin_scenes() {
  static const std::vector<BuiltinScene> all = [] {
    std::vector<BuiltinScene> rows;
    for (const auto& family : {room_scenes(), many_light_scenes(), mesh_scenes(), stadium_scenes(), exact_scenes(),
                               cavity_scenes(), specular_scenes(), border_scenes(), occluder_scenes(), glowing_room_scenes(),
                               sunlit_scenes(), lamp_scenes(), glossy_scenes(), heap_scenes()})
      rows.insert(rows.end(), family.begin(), family.end());
    return rows;
  }();
  return all;
}

}  // namespace etendue
