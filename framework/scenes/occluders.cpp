// Exact scenes of irradiance that changes faster than what a hemisphere of rays tells of: where irradiance caches blur, leak or
// place too few records. One diffuse floor; all else is black or emits, so the floor's light is that of parts of rectangles and
// discs. It comes through a veil (exact_stage.h): irradiance caches take it for indirect light.
#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/exact_stage.h"

#include <span>

namespace etendue {

namespace {

const dvec3 up(0, 1, 0);
const Rgb floor_albedo(0.7f, 0.66f, 0.6f);

// A level rectangle above the floor y = 0.
struct Plate {
  float height;
  vec2 lower, upper;  // x and z

  MeshData facing_down() const { return turned(true); }
  MeshData facing_up() const { return turned(false); }
  MeshData turned(bool down) const {
    const vec3 a(lower.x, height, lower.y), b(upper.x, height, lower.y), c(upper.x, height, upper.y),
        d(lower.x, height, upper.y);
    return down ? quad(a, b, c, d) : quad(d, c, b, a);
  }
  Plate wider(float margin, float at) const { return {at, lower - margin, upper + margin}; }
};

struct Span2 {
  dvec2 lower, upper;

  bool empty() const { return lower.x >= upper.x || lower.y >= upper.y; }
  Span2 cut(const Span2& other) const { return {glm::max(lower, other.lower), glm::min(upper, other.upper)}; }
};

double irradiance_of(const dvec3& point, const Span2& part, double height) {
  if (part.empty()) return 0;
  return polygon_irradiance(point, up,
                            {{part.lower.x, height, part.lower.y},
                             {part.upper.x, height, part.lower.y},
                             {part.upper.x, height, part.upper.y},
                             {part.lower.x, height, part.upper.y}});
}

// Irradiance from a horizontal light of unit radiance behind at most two horizontal plates. Seen from the point, the plates
// cover rectangles of the light's plane, whose union is subtracted from the light by inclusion and exclusion.
double shadowed_irradiance(const dvec3& point, const Plate& light, std::span<const Plate> occluders) {
  const Span2 whole{dvec2(light.lower), dvec2(light.upper)};
  const auto shadow = [&](const Plate& plate) {
    const double scale = light.height / static_cast<double>(plate.height);
    const dvec2 p(point.x, point.z);
    return Span2{p + (dvec2(plate.lower) - p) * scale, p + (dvec2(plate.upper) - p) * scale};
  };
  double sum = irradiance_of(point, whole, light.height);
  for (const Plate& plate : occluders) sum -= irradiance_of(point, whole.cut(shadow(plate)), light.height);
  if (occluders.size() == 2)
    sum += irradiance_of(point, whole.cut(shadow(occluders[0])).cut(shadow(occluders[1])), light.height);
  return std::max(0.0, sum);
}

// The floor, of radiance albedo E / pi.
void add_floor(ExactStage& s, const Plate& floor, std::function<dvec3(const dvec3&)> irradiance) {
  s.reflector(floor.facing_up(), s.builder.material(Diffuse{floor_albedo}),
              [irradiance](const dvec3& p) { return dvec3(floor_albedo) / pi_d * irradiance(p); });
}

// The veil hangs a centimetre before a light, and reaches as far beyond it as rays from the floor could slip through.
constexpr float veil_gap = 0.01f, veil_margin = 0.08f;

void add_light(ExactStage& s, const Plate& light, const Rgb& radiance, bool veil) {
  s.emitter(light.facing_down(), radiance);
  if (veil) s.veil(light.wider(veil_margin, light.height - veil_gap).facing_down());
}

Scene occluded_floor(const char* name, const Plate& light, const Rgb& radiance, std::vector<Plate> occluders, bool veil,
                     const vec3& eye, const vec3& target, float fov) {
  ExactStage s(std::string("builtin:") + name);
  add_floor(s, {0, vec2(-2), vec2(2)},
            [=](const dvec3& p) { return dvec3(radiance) * shadowed_irradiance(p, light, occluders); });
  add_light(s, light, radiance, veil);
  for (const Plate& plate : occluders) s.blocker(plate.facing_up());
  s.builder.camera(eye, target, fov, exact_resolution);
  return s.finish("rectangular light less the plates' shadows on it: E = L/2 sum theta_i (Gamma_i . n)");
}

struct BroadLightParams : VeilParams {
  float height = 1.3f;
};

template <class Visitor>
void describe(Visitor& v, BroadLightParams& p) {
  v.number("height", p.height, 1.3, 100, "m",
           "of the light, which is 1.23 times as wide: the length on which irradiance changes");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_broad_light(const BroadLightParams& params) {  // no occluder: smooth everywhere, for rates of convergence
  const float half = params.height * (0.8f / 1.3f);
  const Plate light{params.height, vec2(-half), vec2(half)};
  return occluded_floor("broad-light", light, Rgb(4, 3.7f, 3.2f), {}, params.veil, {0, 1.25f, 0.15f}, {0, 0, 0}, 100);
}

struct TwoOccludersParams : VeilParams {
  float light = 1;
};

template <class Visitor>
void describe(Visitor& v, TwoOccludersParams& p) {
  v.number("light", p.light, 0.1, 10, "of 1.8 m x 1.4 m",
           "size of the light behind the plates: up to size 2, some of the floor is black; from 2.5 on, none");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_two_occluders(const TwoOccludersParams& params) {  // a wide light, two plates between: penumbrae across each other
  const Plate light{2, params.light * vec2(-0.9f, -0.7f), params.light * vec2(0.9f, 0.7f)};
  const std::vector<Plate> plates{{0.45f, vec2(-0.75f, -0.5f), vec2(-0.15f, 0.45f)},
                                  {0.85f, vec2(-0.05f, -0.6f), vec2(0.7f, 0.25f)}};
  return occluded_floor("two-occluders", light, Rgb(5, 4.6f, 4), plates, params.veil, {0.25f, 1.75f, 3.3f}, {0, 0.12f, -0.1f},
                        40);
}

struct HiddenOccluderParams : VeilParams {
  float light = 0.5f;
};

template <class Visitor>
void describe(Visitor& v, HiddenOccluderParams& p) {
  v.number("light", p.light, 0.01, 4, "m",
           "side of the light, of the same power at any size: a fifth of it is the width of the penumbra");
  describe(v, static_cast<VeilParams&>(p));
}

// A small far light behind a plate: a shadow with hardly a penumbra.
Scene make_hidden_occluder(const HiddenOccluderParams& params) {
  const float half = params.light / 2, dimming = square(0.5f / params.light);
  const Plate light{3, vec2(-half, -half), vec2(half, half)};
  const std::vector<Plate> plates{{0.5f, vec2(-0.1f, -0.7f), vec2(0.9f, 0.5f)}};
  return occluded_floor("hidden-occluder", light, dimming * Rgb(100, 92, 80), plates, params.veil, {-1, 1.7f, 3},
                        {0, 0.05f, -0.1f}, 42);
}

struct SlitLightParams : VeilParams {
  float width = 0.04f;
};

template <class Visitor>
void describe(Visitor& v, SlitLightParams& p) {
  v.number("width", p.width, 1e-4, 3, "m", "of the slit, of the same power at any width");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_slit_light(const SlitLightParams& params) {  // a slit in a wall: few rays find it
  constexpr float wall = -1.2f, low = 0.15f, high = 1.6f;
  const float half = params.width / 2;
  const Rgb radiance = Rgb(160, 145, 120) * (0.04f / params.width);
  ExactStage s("builtin:slit-light");
  // The floor begins behind the veil.
  add_floor(s, {0, vec2(-1.6f, wall + 2 * veil_gap), vec2(1.6f, 1.8f)}, [=](const dvec3& p) {
    return dvec3(radiance) *
           polygon_irradiance(p, up, {{-half, low, wall}, {half, low, wall}, {half, high, wall}, {-half, high, wall}});
  });
  // The wall in four parts around the slit.
  const auto part = [](float x0, float x1, float y0, float y1) {
    return quad({x0, y0, wall}, {x1, y0, wall}, {x1, y1, wall}, {x0, y1, wall});
  };
  s.emitter(part(-half, half, low, high), radiance);
  s.blocker(part(-1.6f, -half, 0, 2));
  s.blocker(part(half, 1.6f, 0, 2));
  s.blocker(part(-half, half, 0, low));
  s.blocker(part(-half, half, high, 2));
  if (params.veil) {
    const float z = wall + veil_gap;
    s.veil(quad({-1.6f, 0, z}, {1.6f, 0, z}, {1.6f, 2, z}, {-1.6f, 2, z}));
  }
  s.builder.camera({0.5f, 1.9f, 2}, {0, 0, 0.35f}, 32, exact_resolution);
  return s.finish("a slit of radiance L: E = L/2 sum theta_i (Gamma_i . n)");
}

struct ThinWallParams : VeilParams {
  float day = 1;
};

template <class Visitor>
void describe(Visitor& v, ThinWallParams& p) {
  v.number("day", p.day, 0.001, 1000, "1", "times the light of the bright side: at 1, it is 15 times as bright as the other");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_thin_wall(const ThinWallParams& params) {  // bright on one side, dim on the other
  // No ray from one light passes over or around the wall to the other floor: the lights lie within the wall's length, and from
  // the far end of the other floor, 1.5 away, the near edge of a light is seen through the height of 1.4 above the wall.
  const Plate bright{2, vec2(-1.3f, -0.8f), vec2(-0.7f, 0.8f)}, dim{2, vec2(0.7f, -0.8f), vec2(1.3f, 0.8f)};
  const Rgb day = params.day * Rgb(12, 11, 9), night(0.5f, 0.65f, 1);
  constexpr float half_thickness = 0.005f, height = 1.45f;
  ExactStage s("builtin:thin-wall");
  const auto side = [&](float x0, float x1, const Plate& light, const Rgb& radiance) {
    add_floor(s, {0, vec2(x0, -1.5f), vec2(x1, 1.5f)},
              [=](const dvec3& p) { return dvec3(radiance) * shadowed_irradiance(p, light, {}); });
    add_light(s, light, radiance, params.veil);
  };
  side(-1.5f, 0, bright, day);
  side(0, 1.5f, dim, night);
  const auto face = [&](float x, bool left) {
    const vec3 a(x, 0, -1.5f), b(x, 0, 1.5f), c(x, height, 1.5f), d(x, height, -1.5f);
    s.blocker(left ? quad(a, b, c, d) : quad(d, c, b, a));
  };
  face(-half_thickness, true);
  face(half_thickness, false);
  s.blocker(Plate{height, vec2(-half_thickness, -1.5f), vec2(half_thickness, 1.5f)}.facing_up());
  s.builder.camera({0.25f, 1.75f, 3.6f}, {0, 0.3f, 0}, 42, exact_resolution);
  return s.finish("on each side of the wall its own rectangular light: E = L/2 sum theta_i (Gamma_i . n)");
}

struct BlackSurroundingsParams : VeilParams {
  float walls = 0;
};

template <class Visitor>
void describe(Visitor& v, BlackSurroundingsParams& p) {
  v.number("walls", p.walls, 0, 100, "W/(m^2 sr)", "radiance of walls and ceiling; that of the light is 13");
  describe(v, static_cast<VeilParams&>(p));
}

// All black but for a small light: nothing to take a distance from, unless the walls glow.
Scene make_black_surroundings(const BlackSurroundingsParams& params) {
  constexpr float radius = 0.35f, height = 1.6f, half = 2, top = 2;
  const Rgb radiance(14, 13.5f, 12), walls(params.walls);
  ExactStage s("builtin:black-surroundings");
  // Above the floor lies nothing but the light and, all around, what glows evenly.
  add_floor(s, {0, vec2(-half), vec2(half)}, [=](const dvec3& p) {
    const double form = disc_irradiance(height, math::hypot(p.x, p.z), radius);
    return dvec3(radiance) * form + dvec3(walls) * (pi_d - form);
  });
  s.builder.quadric(Disk{{0, height, 0}, radius, {0, -1, 0}}, s.black(), radiance);
  if (params.veil) s.veil(Plate{0, vec2(-radius), vec2(radius)}.wider(veil_margin, height - veil_gap).facing_down());
  const auto surround = [](float at, float ceiling, const std::function<void(const MeshData&)>& add) {
    add(Plate{ceiling, vec2(-at), vec2(at)}.facing_down());
    add(quad({-at, 0, -at}, {at, 0, -at}, {at, ceiling, -at}, {-at, ceiling, -at}));
    add(quad({at, 0, at}, {-at, 0, at}, {-at, ceiling, at}, {at, ceiling, at}));
    add(quad({-at, 0, at}, {-at, 0, -at}, {-at, ceiling, -at}, {-at, ceiling, at}));
    add(quad({at, 0, -at}, {at, 0, at}, {at, ceiling, at}, {at, ceiling, -at}));
  };
  if (params.walls > 0) {
    surround(half, top, [&](const MeshData& wall) { s.emitter(wall, walls); });
    if (params.veil) surround(half - veil_gap, top - veil_gap, [&](const MeshData& wall) { s.veil(wall); });
  } else {
    surround(half, top, [&](const MeshData& wall) { s.blocker(wall); });
  }
  s.builder.camera({0.3f, 1.25f, 1.9f}, {0, 0, -0.25f}, 60, exact_resolution);
  return s.finish("a small disc over a floor in a black room");
}

}  // namespace

std::vector<BuiltinScene> occluder_scenes() {
  return {with_params<make_broad_light>("broad-light", "exact: a wide light over a floor: irradiance smooth everywhere"),
          with_params<make_two_occluders>("two-occluders", "exact: a wide light behind two plates, for irradiance caches"),
          with_params<make_hidden_occluder>("hidden-occluder", "exact: a shadow of which the hemisphere tells caches nothing"),
          with_params<make_slit_light>("slit-light", "exact: light from a slit, which few rays find"),
          with_params<make_thin_wall>("thin-wall", "exact: bright before a thin wall, dim behind it"),
          with_params<make_black_surroundings>("black-surroundings", "exact: a small light in a black room")};
}

}  // namespace etendue
