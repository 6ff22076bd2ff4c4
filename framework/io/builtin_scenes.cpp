#include "framework/io/builtin_exact.h"
#include "framework/io/builtin_meshes.h"
#include "framework/io/builtin_rooms.h"
#include "framework/io/load_scene.h"

namespace etendue {

namespace {

template <class Params, Scene (*make)(const Params&)>
BuiltinScene with_params(const char* name, const char* summary) {
  const std::string owner = std::string("builtin:") + name;
  return {name,
          summary,
          [] { return make({}); },
          list_params<Params>(),
          [owner](const ParamMap& map) { read_params<Params>(map, owner); },
          [owner](const ParamMap& map) { return make(read_params<Params>(map, owner)); }};
}

}  // namespace

std::span<const BuiltinScene> builtin_scenes() {
  static const BuiltinScene all[] = {
      {"cornell-box", "diffuse interreflection in a box of coloured walls", make_cornell_box},
      {"cornell-spheres", "the box with a mirror and a glass sphere: caustics", make_cornell_spheres},
      {"glass-caustic", "a caustic under glass and in a mirror: specular-diffuse-specular paths", make_glass_caustic},
      {"two-rooms", "a room lit through a door ajar: hard to find light", make_two_rooms},
      {"veach-mis", "plates of four roughnesses, lights of four sizes: where sampling strategies trade places", make_veach_mis},
      with_params<MeshParams, make_mesh>("mesh", "a displaced ball of many triangles in the box"),
      {"mesh-large", "the same of 1,600,000 triangles", [] { return make_mesh({1'600'000}); }},
      with_params<StadiumParams, make_stadium>("stadium", "the ball in a stadium: dense in little of a large space"),
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
