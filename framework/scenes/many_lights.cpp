// A hall of pillars lit by many small triangles: for how methods choose among lights. Their powers are spread over three orders
// of magnitude; together they have the same power and the same area whatever their number. They face away from the camera, so
// that an image's error is that of what they light, not of their own edges.
#include "framework/core/elementary.h"
#include "framework/core/rng.h"
#include "framework/core/sampling.h"
#include "framework/scene/builder.h"
#include "framework/scenes/builtin_scenes.h"

#include <cmath>

namespace etendue {

namespace {

const vec3 hall_lower(-10, 0, -16), hall_upper(10, 6, 16);  // of the hall, metres
const vec3 eye(-7.5f, 3.2f, -15.5f);
constexpr float total_area = 0.5f;           // m^2, of all lights
constexpr float total_radiance = 1500;       // mean over that area, W/(m^2 sr)
constexpr float decades = 3;                 // from the weakest light to the strongest
constexpr float pillar = 0.5f, gap = 0.25f;  // half the width of a pillar, and how far lights stay from all surfaces, metres

vec2 pillar_at(int i) { return {-6 + 4 * static_cast<float>(i % 4), -12 + 6 * static_cast<float>(i / 4)}; }
constexpr int pillars = 20;

bool is_free(const vec3& p) {
  for (int i = 0; i < pillars; ++i)
    if (max_component(vec3(glm::abs(vec2(p.x, p.z) - pillar_at(i)), 0)) < pillar + gap) return false;
  return length_squared(p - eye) > 4;
}

// The i-th point of an additive recurrence over the hall, even at any number of them ([Roberts2018]).
vec3 place(std::uint32_t i) {
  static const dvec3 steps(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
  const dvec3 at = glm::fract(0.5 + static_cast<double>(i) * steps);
  return hall_lower + gap + vec3(at) * (hall_upper - hall_lower - 2 * gap);
}

float number(std::uint32_t light, int which) {
  return to_unit_float(static_cast<std::uint32_t>(hash_keys(light, which) >> 32));
}

// Away from the camera, within 70 degrees.
vec3 facing(std::uint32_t light, const vec3& position) {
  const vec3 cone = sample_cone(vec2(number(light, 0), number(light, 1)), 1 - math::cos(70 * pi / 180));
  return Frame::from_normal(glm::normalize(position - eye)).to_world(cone);
}

MeshData light_triangle(const vec3& centre, const vec3& normal, float area) {
  const float radius = std::sqrt(area * 4 / (3 * std::sqrt(3.0f)));  // of the circle about an equilateral triangle
  const Frame frame = Frame::from_normal(normal);
  MeshData mesh;
  for (int i = 0; i < 3; ++i) {
    const float angle = 2 * pi / 3 * static_cast<float>(i);
    mesh.positions.push_back(centre + radius * (math::cos(angle) * frame.tangent + math::sin(angle) * frame.bitangent));
  }
  mesh.triangles.push_back({0, 1, 2});
  return mesh;
}

void add_hall(SceneBuilder& b) {
  const auto wall = b.material(Diffuse{Rgb(0.6f, 0.58f, 0.54f)});
  const auto floor = b.material(Diffuse{Rgb(0.45f, 0.4f, 0.35f)});
  const auto blue = b.material(Diffuse{Rgb(0.25f, 0.35f, 0.6f)});
  const vec3 l = hall_lower, u = hall_upper;
  b.mesh(quad({l.x, 0, u.z}, {u.x, 0, u.z}, {u.x, 0, l.z}, {l.x, 0, l.z}), floor);
  b.mesh(quad({l.x, u.y, l.z}, {u.x, u.y, l.z}, {u.x, u.y, u.z}, {l.x, u.y, u.z}), wall);
  b.mesh(quad({l.x, 0, l.z}, {u.x, 0, l.z}, {u.x, u.y, l.z}, {l.x, u.y, l.z}), wall);
  b.mesh(quad({u.x, 0, u.z}, {l.x, 0, u.z}, {l.x, u.y, u.z}, {u.x, u.y, u.z}), blue);
  b.mesh(quad({l.x, 0, u.z}, {l.x, 0, l.z}, {l.x, u.y, l.z}, {l.x, u.y, u.z}), wall);
  b.mesh(quad({u.x, 0, l.z}, {u.x, 0, u.z}, {u.x, u.y, u.z}, {u.x, u.y, l.z}), wall);
  for (int i = 0; i < pillars; ++i) {
    const vec2 at = pillar_at(i);
    b.mesh(box({at.x - pillar, 0, at.y - pillar}, {at.x + pillar, u.y, at.y + pillar}), i % 3 == 0 ? blue : wall);
  }
}

struct ManyLightsParams {
  int lights = 1000;
};

template <class Visitor>
void describe(Visitor& v, ManyLightsParams& p) {
  v.integer("lights", p.lights, 1, 1'000'000, "lights", "small triangles spread over the hall");
}

Scene make_many_lights(const ManyLightsParams& params) {
  SceneBuilder b("builtin:many-lights");
  add_hall(b);
  const auto count = static_cast<std::uint32_t>(params.lights);
  std::vector<float> weights;
  double sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    weights.push_back(math::pow(10.0f, decades * number(i, 2)));
    sum += weights.back();
  }
  const auto black = b.material(Diffuse{Rgb(0)});
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    vec3 position = place(next++);
    while (!is_free(position)) position = place(next++);
    const float radiance = total_radiance * static_cast<float>(weights[i] * count / sum), tint = 0.3f * number(i, 3);
    b.mesh(light_triangle(position, facing(i, position), total_area / static_cast<float>(count)), black,
           radiance * Rgb(1 + 0.5f * tint, 1, 1 - tint));
  }
  b.camera(eye, {2, 2.2f, 4}, 62, {256, 144});
  return b.finish();
}

}  // namespace

std::vector<BuiltinScene> many_light_scenes() {
  return {with_params<make_many_lights>("many-lights", "a hall of pillars and many small lights of all powers")};
}

}  // namespace etendue
