#include "framework/io/builtin_exact.h"
#include "framework/io/builtin_rooms.h"
#include "framework/io/load_scene.h"

namespace etendue {

std::span<const BuiltinScene> builtin_scenes() {
  static const BuiltinScene all[] = {
      {"cornell-box", "diffuse interreflection in a box of coloured walls", make_cornell_box},
      {"cornell-spheres", "the box with a mirror and a glass sphere: caustics", make_cornell_spheres},
      {"glass-caustic", "a caustic under glass and in a mirror: specular-diffuse-specular paths", make_glass_caustic},
      {"two-rooms", "a room lit through a door ajar: hard to find light", make_two_rooms},
      {"veach-mis", "plates of four roughnesses, lights of four sizes: where sampling strategies trade places", make_veach_mis},
      {"mesh", "100,000 triangles, displaced ball", make_mesh},
      {"mesh-large", "1,600,000 triangles, displaced ball", make_mesh_large},
      {"lambert-sphere", "exact: diffuse sphere, point light at the centre", make_lambert_sphere},
      {"lambert-sphere-off-centre", "exact: diffuse sphere, point light off the centre", make_lambert_sphere_off_centre},
      {"furnace", "exact: closed sphere that emits and reflects evenly", make_furnace},
      {"white-furnace", "exact: lossless glass, mirror, plastic and white in a unit environment", make_white_furnace},
      {"polygon-light", "exact: direct light of a rectangle", make_polygon_light},
      {"sphere-light", "exact: direct light of a sphere", make_sphere_light},
      {"disc-light", "exact: direct light of a disc", make_disc_light},
  };
  return all;
}

}  // namespace etendue
