#include "framework/io/load_scene.h"
#include "framework/scenes/borders.h"
#include "framework/scenes/cavities.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/glowing_room.h"
#include "framework/scenes/meshes.h"
#include "framework/scenes/occluders.h"
#include "framework/scenes/rooms.h"
#include "framework/scenes/specular.h"

namespace etendue {

namespace {

template <class Params, Scene (*make)(const Params&)>
BuiltinScene with_params(const char* name, const char* summary) {
  return scene_with_params<Params, make>(builtin_prefix, name, summary);
}

}  // namespace

std::span<const BuiltinScene> builtin_scenes() {
  static const BuiltinScene all[] = {
      {"cornell-box", "diffuse interreflection in a box of coloured walls", make_cornell_box},
      {"cornell-spheres", "the box with a mirror and a glass sphere: caustics", make_cornell_spheres},
      {"glass-caustic", "a caustic under glass and in a mirror: specular-diffuse-specular paths", make_glass_caustic},
      {"two-rooms", "a room lit through a door ajar: hard to find light", make_two_rooms},
      {"veach-mis", "plates of four roughnesses, lights of four sizes: where sampling strategies trade places", make_veach_mis},
      with_params<GlossyBoxParams, make_glossy_cornell_box>("glossy-cornell-box", "the box on a floor of brushed metal"),
      {"keyhole", "a room lit through a keyhole: nearly all light stays behind the door", make_keyhole},
      {"exterior", "a room in a city in the sun: nearly all light falls elsewhere", make_exterior},
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
      with_params<CavityParams, make_cavity>("cavity", "exact: spherical cavity with an opening to a unit environment"),
      {"concentric-spheres", "exact: a glowing sphere in a glowing sphere", make_concentric_spheres},
      with_params<MirrorParams, make_mirror>("mirror", "exact: point light, mirror and diffuse floor"),
      with_params<WaterParams, make_water>("water", "exact: point light above water, diffuse floor below"),
      with_params<VeilParams, make_edge>("edge", "exact: even light up to a border, where density estimates darken"),
      with_params<VeilParams, make_corner>("corner", "exact: even light on two walls that meet"),
      with_params<ThinPlateParams, make_thin_plate>("thin-plate", "exact: a plate in the sun from below, where density leaks"),
      with_params<BroadLightParams, make_broad_light>("broad-light",
                                                      "exact: a wide light over a floor: irradiance smooth everywhere"),
      with_params<TwoOccludersParams, make_two_occluders>("two-occluders",
                                                          "exact: a wide light behind two plates, for irradiance caches"),
      with_params<GlowingRoomParams, make_glowing_room>("glowing-room",
                                                        "exact: a room of glowing walls and two boxes, for irradiance caches"),
      with_params<VeilParams, make_hidden_occluder>("hidden-occluder",
                                                    "exact: a shadow of which the hemisphere tells caches nothing"),
      with_params<VeilParams, make_slit_light>("slit-light", "exact: light from a slit, which few rays find"),
      with_params<VeilParams, make_thin_wall>("thin-wall", "exact: bright before a thin wall, dim behind it"),
      with_params<VeilParams, make_black_surroundings>("black-surroundings", "exact: a small light in a black room"),
  };
  return all;
}

}  // namespace etendue
