#include "framework/io/load_scene.h"
#include "framework/scenes/borders.h"
#include "framework/scenes/cavities.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/glossy_furnace.h"
#include "framework/scenes/glowing_room.h"
#include "framework/scenes/heaps.h"
#include "framework/scenes/lamps.h"
#include "framework/scenes/many_lights.h"
#include "framework/scenes/meshes.h"
#include "framework/scenes/occluders.h"
#include "framework/scenes/rooms.h"
#include "framework/scenes/specular.h"
#include "framework/scenes/sunlit.h"

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
      with_params<KeyholeParams, make_keyhole>("keyhole",
                                               "a room lit through a keyhole: nearly all light stays behind the door"),
      {"exterior", "a room in a city in the sun: nearly all light falls elsewhere", make_exterior},
      with_params<ManyLightsParams, make_many_lights>("many-lights", "a hall of pillars and many small lights of all powers"),
      with_params<MeshParams, make_mesh>("mesh", "a displaced ball of many triangles in the box"),
      {"mesh-large", "the same of 1,600,000 triangles", [] { return make_mesh({1'600'000}); }},
      with_params<StadiumParams, make_stadium>("stadium", "the ball in a stadium: dense in little of a large space"),
      with_params<ReflectedParams, make_lambert_sphere>("lambert-sphere", "exact: diffuse sphere, point light at the centre"),
      {"lambert-sphere-off-centre", "exact: diffuse sphere, point light off the centre", make_lambert_sphere_off_centre},
      with_params<ReflectedParams, make_furnace>("furnace", "exact: closed sphere that emits and reflects evenly"),
      {"white-furnace", "exact: lossless glass, mirror, plastic and white in a unit environment", make_white_furnace},
      {"polygon-light", "exact: direct light of a rectangle", make_polygon_light},
      {"sphere-light", "exact: direct light of a sphere", make_sphere_light},
      {"disc-light", "exact: direct light of a disc", make_disc_light},
      with_params<CavityParams, make_cavity>("cavity", "exact: spherical cavity with an opening to a unit environment"),
      {"concentric-spheres", "exact: a glowing sphere in a glowing sphere", make_concentric_spheres},
      with_params<MirrorParams, make_mirror>("mirror", "exact: point light, mirror and diffuse floor"),
      with_params<WaterParams, make_water>("water", "exact: point light above water, diffuse floor below"),
      with_params<EdgeParams, make_edge>("edge", "exact: even light up to a border, where density estimates darken"),
      with_params<VeilParams, make_corner>("corner", "exact: even light on two walls that meet"),
      with_params<ThinPlateParams, make_thin_plate>("thin-plate", "exact: a plate in the sun from below, where density leaks"),
      with_params<BroadLightParams, make_broad_light>("broad-light",
                                                      "exact: a wide light over a floor: irradiance smooth everywhere"),
      with_params<TwoOccludersParams, make_two_occluders>("two-occluders",
                                                          "exact: a wide light behind two plates, for irradiance caches"),
      with_params<GlowingRoomParams, make_glowing_room>("glowing-room",
                                                        "exact: a room of glowing walls and two boxes, for irradiance caches"),
      with_params<HiddenOccluderParams, make_hidden_occluder>("hidden-occluder",
                                                              "exact: a shadow of which the hemisphere tells caches nothing"),
      with_params<SlitLightParams, make_slit_light>("slit-light", "exact: light from a slit, which few rays find"),
      with_params<ThinWallParams, make_thin_wall>("thin-wall", "exact: bright before a thin wall, dim behind it"),
      with_params<BlackSurroundingsParams, make_black_surroundings>("black-surroundings",
                                                                    "exact: a small light in a black room"),
      with_params<SunlitFieldParams, make_sunlit_field>("sunlit-field", "exact: the middle of a field in the sun"),
      with_params<SunlitBallParams, make_sunlit_ball>("sunlit-ball", "exact: a ball in the sun, for kernels as wide as it"),
      with_params<FarKerbParams, make_far_kerb>("far-kerb", "exact: the shadow of a kerb, far from the origin of floats"),
      with_params<VeiledLampParams, make_veiled_lamp>("veiled-lamp", "exact: a lamp behind glass, at any size"),
      with_params<ManyLampsParams, make_many_lamps>("many-lamps", "exact: one lamp that lights, among many that do not"),
      with_params<GlossyFurnaceParams, make_glossy_furnace>("glossy-furnace", "exact: a rough mirror in a glowing sphere"),
      with_params<GlossyLampParams, make_glossy_lamp>("glossy-lamp", "exact: a lamp of any size in a mirror of any roughness"),
      with_params<CoincidentParams, make_coincident>("coincident", "a ball, copied into its place"),
      with_params<SliversParams, make_slivers>("slivers", "triangles as long and narrow as asked for"),
      with_params<OverlapParams, make_overlap>("overlap", "triangles as near to each other as asked for"),
  };
  return all;
}

}  // namespace etendue
