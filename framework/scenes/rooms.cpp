// Built-in scenes without a closed form, each there for what it asks of a method.
#include "framework/scene/builder.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/meshes.h"

namespace etendue {

namespace {

const ivec2 room_resolution{192, 192};

// The box: x and z in [-1, 1], y in [0, 2], open to the camera at +z; red on the left, green on the right.
void cornell_walls(SceneBuilder& b, const std::optional<Material>& floor = std::nullopt) {
  const auto white = b.material(Diffuse{Rgb(0.73f, 0.73f, 0.73f)});
  const auto red = b.material(Diffuse{Rgb(0.63f, 0.065f, 0.05f)});
  const auto green = b.material(Diffuse{Rgb(0.14f, 0.45f, 0.091f)});
  b.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), floor ? b.material(*floor) : white);
  b.mesh(quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}), white);
  b.mesh(quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}), white);
  b.mesh(quad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}), red);
  b.mesh(quad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1}), green);
}

void ceiling_light(SceneBuilder& b) {
  b.mesh(quad({-0.25f, 1.98f, -0.25f}, {0.25f, 1.98f, -0.25f}, {0.25f, 1.98f, 0.25f}, {-0.25f, 1.98f, 0.25f}),
         b.material(Diffuse{Rgb(0)}), Rgb(17, 12, 4) * 1.5f);
}

void cornell_camera(SceneBuilder& b) { b.camera({0, 1, 3.8f}, {0, 1, 0}, 40, room_resolution); }

MeshData turned_box(const vec3& centre, const vec3& half, float degrees) {
  return transformed(box(-half, half), Transform::translate(centre) * Transform::rotate(degrees * pi / 180, {0, 1, 0}));
}

void cornell_boxes(SceneBuilder& b) {
  const auto white = b.material(Diffuse{Rgb(0.73f)});
  b.mesh(turned_box({-0.33f, 0.6f, -0.35f}, {0.3f, 0.6f, 0.3f}, 18), white);
  b.mesh(turned_box({0.36f, 0.3f, 0.3f}, {0.3f, 0.3f, 0.3f}, -17), white);
}

Scene make_cornell_box() {  // diffuse interreflection
  SceneBuilder b("builtin:cornell-box");
  cornell_walls(b);
  ceiling_light(b);
  cornell_boxes(b);
  cornell_camera(b);
  return b.finish();
}

struct GlossyBoxParams {
  float alpha = 0.15f;
};

template <class Visitor>
void describe(Visitor& v, GlossyBoxParams& p) {
  v.number("alpha", p.alpha, 0.01, 1, "GGX alpha", "roughness of the floor");
}

// The box with boxes on a floor of brushed metal: too narrow a lobe for a cache of irradiance, wide enough for one of radiance.
Scene make_glossy_cornell_box(const GlossyBoxParams& params) {
  SceneBuilder b("builtin:glossy-cornell-box");
  cornell_walls(b, Conductor{.tint = Rgb(0.75f), .ideal = true, .alpha = vec2(params.alpha)});
  ceiling_light(b);
  cornell_boxes(b);
  cornell_camera(b);
  return b.finish();
}

Scene make_cornell_spheres() {  // a mirror and a glass sphere: caustics, directly seen
  SceneBuilder b("builtin:cornell-spheres");
  cornell_walls(b);
  ceiling_light(b);
  b.quadric(Sphere{{-0.45f, 0.4f, -0.4f}, 0.4f}, b.material(Conductor{.tint = Rgb(0.95f), .ideal = true}));
  b.quadric(Sphere{{0.45f, 0.4f, 0.25f}, 0.4f}, b.material(Dielectric{.eta = 1.5f}));
  cornell_camera(b);
  return b.finish();
}

Scene make_glass_caustic() {  // a caustic under glass, also seen through a mirror: SDS paths
  SceneBuilder b("builtin:glass-caustic");
  const auto floor = b.material(Diffuse{Rgb(0.7f)});
  const auto wall = b.material(Diffuse{Rgb(0.35f, 0.4f, 0.5f)});
  b.mesh(quad({-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}), floor);
  b.mesh(quad({-3, 0, -3}, {3, 0, -3}, {3, 4, -3}, {-3, 4, -3}), wall);
  b.mesh(quad({-3, 0, 3}, {-3, 0, -3}, {-3, 4, -3}, {-3, 4, 3}), wall);
  // The mirror stands behind and shows the caustic again; the slab of glass lies over half of it.
  b.mesh(quad({0.4f, 0.05f, -2.2f}, {2.4f, 0.05f, -1.2f}, {2.4f, 1.8f, -1.2f}, {0.4f, 1.8f, -2.2f}),
         b.material(Conductor{.tint = Rgb(0.9f), .ideal = true}));
  const auto glass = b.material(Dielectric{.eta = 1.5f});
  b.quadric(Sphere{{-0.3f, 0.75f, 0}, 0.6f}, glass);
  b.mesh(box({0.15f, 0.05f, -0.3f}, {1.25f, 0.2f, 0.9f}), glass);
  b.quadric(Sphere{{-2, 3, 0.4f}, 0.15f}, b.material(Diffuse{Rgb(0)}), Rgb(130, 120, 100));
  b.camera({0.6f, 2.2f, 4.6f}, {0.2f, 0.55f, -0.2f}, 42, {256, 192});
  return b.finish();
}

Scene make_two_rooms() {  // light comes through a door ajar
  SceneBuilder b("builtin:two-rooms");
  const auto white = b.material(Diffuse{Rgb(0.75f)});
  const auto floor = b.material(Diffuse{Rgb(0.55f, 0.42f, 0.3f)});
  const auto blue = b.material(Diffuse{Rgb(0.25f, 0.35f, 0.6f)});
  // Two rooms side by side along x, a wall between them with a doorway, and a door left ajar by 15 degrees.
  b.mesh(quad({-4, 0, 2}, {4, 0, 2}, {4, 0, -2}, {-4, 0, -2}), floor);
  b.mesh(quad({-4, 2.5f, -2}, {4, 2.5f, -2}, {4, 2.5f, 2}, {-4, 2.5f, 2}), white);
  b.mesh(quad({-4, 0, -2}, {4, 0, -2}, {4, 2.5f, -2}, {-4, 2.5f, -2}), white);
  b.mesh(quad({4, 0, 2}, {-4, 0, 2}, {-4, 2.5f, 2}, {4, 2.5f, 2}), white);
  b.mesh(quad({-4, 0, 2}, {-4, 0, -2}, {-4, 2.5f, -2}, {-4, 2.5f, 2}), blue);
  b.mesh(quad({4, 0, -2}, {4, 0, 2}, {4, 2.5f, 2}, {4, 2.5f, -2}), white);
  b.mesh(box({-0.05f, 0, -2}, {0.05f, 2.5f, -0.5f}), white);
  b.mesh(box({-0.05f, 0, 0.5f}, {0.05f, 2.5f, 2}), white);
  b.mesh(box({-0.05f, 2, -0.5f}, {0.05f, 2.5f, 0.5f}), white);
  const Transform ajar = Transform::translate({-0.05f, 0, -0.5f}) * Transform::rotate(-15 * pi / 180, {0, 1, 0});
  b.mesh(transformed(box({-0.04f, 0.01f, 0}, {0, 1.99f, 0.99f}), ajar), b.material(Diffuse{Rgb(0.45f, 0.25f, 0.12f)}));
  b.mesh(turned_box({-1.9f, 0.35f, -0.9f}, {0.35f, 0.35f, 0.35f}, 30), white);
  b.quadric(Sphere{{-1.4f, 0.3f, 0.4f}, 0.3f}, b.material(Diffuse{Rgb(0.7f, 0.6f, 0.2f)}));
  // The only light is in the other room.
  b.mesh(quad({2, 2.45f, -0.5f}, {3, 2.45f, -0.5f}, {3, 2.45f, 0.5f}, {2, 2.45f, 0.5f}), b.material(Diffuse{Rgb(0)}), Rgb(60));
  b.camera({-3.7f, 1.4f, 1.2f}, {-0.6f, 0.85f, -0.35f}, 55, {256, 192});
  return b.finish();
}

Scene make_veach_mis() {  // four plates of growing roughness, four spheres of growing size
  SceneBuilder b("builtin:veach-mis");
  const auto grey = b.material(Diffuse{Rgb(0.4f)});
  b.mesh(quad({-10, -4.15f, 12}, {10, -4.15f, 12}, {10, -4.15f, -10}, {-10, -4.15f, -10}), grey);
  b.mesh(quad({-10, -4.15f, -3}, {10, -4.15f, -3}, {10, 16, -3}, {-10, 16, -3}), grey);
  // Centres and slopes after [Veach1995] fig. 2 as the field has it: each plate mirrors the lights to the eye.
  const Rgb gold_eta(0.143f, 0.375f, 1.442f), gold_k(3.983f, 2.386f, 1.603f);
  const struct {
    float height, depth, slope, alpha;
  } plates[] = {
      {-2.71f, 0.33f, 35, 0.005f}, {-3.29f, 1.56f, 25.6f, 0.02f}, {-3.77f, 3.06f, 18.3f, 0.05f}, {-4.07f, 4.9f, 11.9f, 0.1f}};
  for (const auto& p : plates) {
    const Transform t = Transform::translate({0, p.height + 0.35f, p.depth}) * Transform::rotate(p.slope * pi / 180, {1, 0, 0});
    b.mesh(transformed(box({-4, -0.03f, -0.62f}, {4, 0.03f, 0.62f}), t),
           b.material(Conductor{.eta = gold_eta, .k = gold_k, .alpha = vec2(p.alpha)}));
  }
  const auto dark = b.material(Diffuse{Rgb(0)});
  const struct {
    float x, radius;
    Rgb colour;
  } lights[] = {{-3.75f, 0.03333f, {1, 0.45f, 0.35f}},
                {-1.25f, 0.1f, {1, 0.9f, 0.4f}},
                {1.25f, 0.3f, {0.45f, 1, 0.5f}},
                {3.75f, 0.9f, {0.4f, 0.55f, 1}}};
  for (const auto& l : lights) b.quadric(Sphere{{l.x, 0.5f, 0}, l.radius}, dark, l.colour * (0.9f / (l.radius * l.radius)));
  b.light(PointLight{{0, 10, 10}, Rgb(60)});
  b.camera({0, 2, 15}, {0, -1.6f, 2.5f}, 28, {256, 170});
  return b.finish();
}

struct KeyholeParams {
  float size = 1;
};

template <class Visitor>
void describe(Visitor& v, KeyholeParams& p) {
  v.number("size", p.size, 0.01, 4, "of 20 cm x 35 cm", "of the keyhole");
}

// A dark room beside a bright one: all its light comes through the keyhole of a door.
Scene make_keyhole(const KeyholeParams& params) {
  SceneBuilder b("builtin:keyhole");
  const auto white = b.material(Diffuse{Rgb(0.75f)});
  const auto boards = b.material(Diffuse{Rgb(0.5f, 0.4f, 0.3f)});
  const auto door = b.material(Diffuse{Rgb(0.5f, 0.28f, 0.15f)});
  constexpr float w = 2.6f, d = 1.5f, h = 2.4f;  // of each room: length, half the width, height
  b.mesh(quad({-w, 0, d}, {w, 0, d}, {w, 0, -d}, {-w, 0, -d}), boards);
  b.mesh(quad({-w, h, -d}, {w, h, -d}, {w, h, d}, {-w, h, d}), white);
  b.mesh(quad({-w, 0, -d}, {w, 0, -d}, {w, h, -d}, {-w, h, -d}), white);
  b.mesh(quad({w, 0, d}, {-w, 0, d}, {-w, h, d}, {w, h, d}), white);
  b.mesh(quad({-w, 0, d}, {-w, 0, -d}, {-w, h, -d}, {-w, h, d}), white);
  b.mesh(quad({w, 0, -d}, {w, 0, d}, {w, h, d}, {w, h, -d}), white);
  // Wall and door, 4 cm thick, around a keyhole of two rectangles: a slot below a head twice as wide.
  const auto piece = [&](float y0, float y1, float z0, float z1, std::uint32_t material) {
    b.mesh(box({-0.02f, y0, z0}, {0.02f, y1, z1}), material);
  };
  const float larger = params.size - 1;
  constexpr float leaf = 0.45f, y1 = 1.1f, top = 2;
  const float slot = 0.05f * params.size, head = 0.1f * params.size, y0 = 0.9f - 0.2f * larger, y2 = 1.25f + 0.15f * larger;
  piece(0, h, -d, -leaf, white);
  piece(0, h, leaf, d, white);
  piece(top, h, -leaf, leaf, white);
  piece(0, y0, -leaf, leaf, door);
  piece(y2, top, -leaf, leaf, door);
  for (const float side : {-1.0f, 1.0f}) {
    piece(y0, y1, std::min(side * leaf, side * slot), std::max(side * leaf, side * slot), door);
    piece(y1, y2, std::min(side * leaf, side * head), std::max(side * leaf, side * head), door);
  }
  b.mesh(turned_box({-1.9f, 0.25f, -0.75f}, {0.25f, 0.25f, 0.25f}, 25), b.material(Diffuse{Rgb(0.3f, 0.4f, 0.6f)}));
  // Through the keyhole the lamp lights a spot of the floor.
  b.mesh(quad({0.8f, h - 0.02f, -0.4f}, {1.6f, h - 0.02f, -0.4f}, {1.6f, h - 0.02f, 0.4f}, {0.8f, h - 0.02f, 0.4f}),
         b.material(Diffuse{Rgb(0)}), Rgb(510, 450, 360));
  b.camera({-2.45f, 1.35f, 1.25f}, {-0.4f, 0.75f, -0.35f}, 58, {192, 192});
  return b.finish();
}

// A room with one window, high in a city in the sun: nearly all light falls where the camera does not look.
Scene make_exterior() {
  SceneBuilder b("builtin:exterior");
  constexpr float half_city = 26, storey = 9;
  b.mesh(quad({-half_city, 0, half_city}, {half_city, 0, half_city}, {half_city, 0, -half_city}, {-half_city, 0, -half_city}),
         b.material(Diffuse{Rgb(0.35f, 0.38f, 0.3f)}));
  const std::uint32_t fronts[] = {b.material(Diffuse{Rgb(0.6f, 0.5f, 0.4f)}), b.material(Diffuse{Rgb(0.65f, 0.62f, 0.55f)}),
                                  b.material(Diffuse{Rgb(0.5f, 0.35f, 0.28f)})};
  // Blocks of houses on a grid of 7.5 m; none where the tower with the room stands.
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) {
      if (i == 0 && j == 0) continue;
      const auto hash = static_cast<std::uint32_t>((i + 8) * 73 + (j + 8) * 151);
      const float height = 2.5f + 0.5f * static_cast<float>(hash % 11);
      const vec3 at(7.5f * static_cast<float>(i), 0, 7.5f * static_cast<float>(j));
      b.mesh(box(at - vec3(2.2f, 0, 2.2f), at + vec3(2.2f, height, 2.2f)), fronts[hash % 3]);
    }
  // The tower, and on it the room: 3 x 2.4 x 4 m within walls of 0.2 m; its window looks along +x.
  b.mesh(box({-2, 0, -2.6f}, {2, storey - 0.2f, 2.6f}), fronts[1]);
  const auto plaster = b.material(Diffuse{Rgb(0.75f)});
  const auto boards = b.material(Diffuse{Rgb(0.5f, 0.36f, 0.24f)});
  const auto wall = [&](const vec3& lower, const vec3& upper, std::uint32_t material) {
    b.mesh(box(lower + vec3(0, storey, 0), upper + vec3(0, storey, 0)), material);
  };
  wall({-1.7f, -0.2f, -2.2f}, {1.7f, 0, 2.2f}, boards);
  wall({-1.7f, 2.4f, -2.2f}, {1.7f, 2.6f, 2.2f}, plaster);
  wall({-1.7f, 0, -2.2f}, {1.7f, 2.4f, -2}, plaster);
  wall({-1.7f, 0, 2}, {1.7f, 2.4f, 2.2f}, plaster);
  wall({-1.7f, 0, -2}, {-1.5f, 2.4f, 2}, plaster);
  // The window's wall: below, above, left and right of 1.2 x 1.1 m.
  wall({1.5f, 0, -2}, {1.7f, 0.9f, 2}, plaster);
  wall({1.5f, 2, -2}, {1.7f, 2.4f, 2}, plaster);
  wall({1.5f, 0.9f, -2}, {1.7f, 2, -1.1f}, plaster);
  wall({1.5f, 0.9f, 0.1f}, {1.7f, 2, 2}, plaster);
  wall({-0.9f, 0, -1.7f}, {-0.2f, 0.55f, -0.9f}, b.material(Diffuse{Rgb(0.2f, 0.35f, 0.45f)}));
  b.light(DirectionalLight{.direction = glm::normalize(vec3(-1, -0.75f, 0.3f)), .irradiance = Rgb(24, 21.5f, 17.5f)});
  b.light(EnvironmentLight{.scale = Rgb(0.9f, 1.2f, 1.6f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  b.camera({-1.3f, storey + 1.45f, 1.7f}, {0.75f, storey + 0.75f, -0.75f}, 62, {192, 192});
  return b.finish();
}

// A displaced ball in the Cornell box: triangles of like size, spread evenly.
struct MeshParams {
  int triangles = 100'000;
};

template <class Visitor>
void describe(Visitor& v, MeshParams& params) {
  v.integer("triangles", params.triangles, 100, 50'000'000, "triangles", "of the ball, to within a percent");
}

Scene make_mesh(const MeshParams& params) {
  SceneBuilder b("builtin:mesh");
  cornell_walls(b);
  ceiling_light(b);
  b.mesh(rough_ball({0, 0.85f, -0.1f}, 0.78f, params.triangles), b.material(Diffuse{Rgb(0.6f)}));
  cornell_camera(b);
  return b.finish();
}

}  // namespace

std::vector<BuiltinScene> room_scenes() {
  return {
      {"cornell-box", "diffuse interreflection in a box of coloured walls", make_cornell_box},
      {"cornell-spheres", "the box with a mirror and a glass sphere: caustics", make_cornell_spheres},
      {"glass-caustic", "a caustic under glass and in a mirror: specular-diffuse-specular paths", make_glass_caustic},
      {"two-rooms", "a room lit through a door ajar: hard to find light", make_two_rooms},
      {"veach-mis", "plates of four roughnesses, lights of four sizes: where sampling strategies trade places", make_veach_mis},
      with_params<make_glossy_cornell_box>("glossy-cornell-box", "the box on a floor of brushed metal"),
      with_params<make_keyhole>("keyhole", "a room lit through a keyhole: nearly all light stays behind the door"),
      {"exterior", "a room in a city in the sun: nearly all light falls elsewhere", make_exterior}};
}

std::vector<BuiltinScene> mesh_scenes() {
  return {with_params<make_mesh>("mesh", "a displaced ball of many triangles in the box"),
          {"mesh-large", "the same of 1,600,000 triangles", [] { return make_mesh({1'600'000}); }}};
}

}  // namespace etendue
