// A closed room whose walls, and two boxes on its floor, glow evenly, each in its own colour, and reflect once: what indirect
// light in a room is to a cache, but known exactly. A square of the ceiling is brighter than the rest. No place is black; the
// boxes make penumbrae and dark corners.
//
// Irradiance is Lambert's sum ([Baum1989]) over what is seen of each glowing rectangle: the part above the horizon, less its
// parts within the pyramids in which the boxes' faces are seen, by inclusion and exclusion: faces of one box do not cover each
// other. The boxes lie on either side of a plane, so that only the one on the point's side can hide the other.
#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/exact_stage.h"

#include <array>
#include <numbers>
#include <span>

namespace etendue {

namespace {

constexpr double sliver = 1e-9;  // distances from planes below which a point lies on them
constexpr int no_box = -1;

// Convex, with few corners: a rectangle cut by a horizon and by pyramids.
struct Polygon {
  std::array<dvec3, 16> corners;
  std::size_t size = 0;

  void add(const dvec3& p) {
    CHECK(size < corners.size());
    corners[size++] = p;
  }
  std::span<const dvec3> all() const { return {corners.data(), size}; }
};

struct CutPlane {
  dvec3 normal;
  double offset;

  double above(const dvec3& p) const { return glm::dot(normal, p) - offset; }
  CutPlane turned() const { return {-normal, -offset}; }
};

using Pyramid = std::array<CutPlane, 4>;  // with its top at a point; normals outward

struct Face {
  std::array<dvec3, 4> corners;
  dvec3 normal;
  Rgb emitted, albedo;
  int box;  // whose it is

  bool faces(const dvec3& p) const { return glm::dot(normal, p - corners[0]) > sliver; }
};

Polygon clipped(const Polygon& polygon, const CutPlane& plane) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const dvec3 &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.size];
    const double above_a = plane.above(a), above_b = plane.above(b);
    if (above_a >= 0) kept.add(a);
    if (above_a * above_b < 0) kept.add(a + above_a / (above_a - above_b) * (b - a));
  }
  if (kept.size < 3) kept.size = 0;
  return kept;
}

// The part within a pyramid.
Polygon within(Polygon polygon, const Pyramid& pyramid) {
  for (const CutPlane& side : pyramid) {
    const auto below = [&](const dvec3& p) { return side.above(p) < sliver; };
    if (!std::all_of(polygon.all().begin(), polygon.all().end(), below)) polygon = clipped(polygon, side.turned());
    if (polygon.size == 0) break;
  }
  return polygon;
}

// The room's faces, and how one hides another.
class GlowingRoom {
 public:
  explicit GlowingRoom(const CutPlane& between) : between_(between) {}

  void add(Face face) { faces_.push_back(std::move(face)); }

  // At a point of a face.
  dvec3 irradiance(const dvec3& point, const Face& on) const {
    const CutPlane horizon{on.normal, glm::dot(on.normal, point)};
    const int nearer = between_.above(point) < 0 ? 0 : 1;  // the box that may hide the other
    static thread_local std::vector<Pyramid> near, far;    // in which its faces and the other's are seen
    near.clear();
    far.clear();
    for (const Face& face : faces_)
      if (face.box != no_box && face.box != on.box && face.faces(point))
        (face.box == nearer ? near : far).push_back(pyramid(face, point));
    const auto form = [&](const Polygon& part) { return part.size > 0 ? polygon_irradiance(point, on.normal, part.all()) : 0; };
    dvec3 sum(0);
    for (const Face& face : faces_) {
      if (!face.faces(point)) continue;
      Polygon whole;
      for (const dvec3& corner : face.corners) whole.add(corner);
      whole = clipped(whole, horizon);
      double seen = form(whole);
      if (face.box != nearer)
        for (const Pyramid& hider : near) seen -= form(within(whole, hider));
      if (face.box == no_box)
        for (const Pyramid& hider : far) {
          const Polygon hidden = within(whole, hider);
          if (hidden.size == 0) continue;
          seen -= form(hidden);
          for (const Pyramid& twice : near) seen += form(within(hidden, twice));
        }
      sum += seen * dvec3(face.emitted);
    }
    return sum;
  }

 private:
  static Pyramid pyramid(const Face& face, const dvec3& top) {
    Pyramid sides;
    const dvec3 middle = 0.5 * (face.corners[0] + face.corners[2]);
    for (std::size_t i = 0; i < 4; ++i) {
      const dvec3 n = glm::normalize(glm::cross(face.corners[i] - top, face.corners[(i + 1) % 4] - top));
      const CutPlane side{n, glm::dot(n, top)};
      sides[i] = side.above(middle) > 0 ? side.turned() : side;
    }
    return sides;
  }

  std::vector<Face> faces_;
  CutPlane between_;
};

// A rectangle from its corner, its sides along u and v; it faces their cross product.
struct Rectangle {
  vec3 corner, u, v;
  Rgb emitted, albedo;
  int box = no_box;
};

// The ceiling is a square panel in its middle and what is left around it.
std::vector<Rectangle> walls(float panel, float glow) {
  const Rgb white(0.73f), red(0.63f, 0.1f, 0.08f), green(0.16f, 0.45f, 0.12f);
  constexpr float w = 1, h = 2, d = 2.6f;
  const vec3 x(2 * w, 0, 0), y(0, h, 0), z(0, 0, d), corner(-w, 0, -1);
  std::vector<Rectangle> all{{corner, z, x, 0.3f * glow * white, white},
                             {corner, x, y, 0.4f * glow * white, white},
                             {corner + z, y, x, 0.6f * glow * white, white},
                             {corner, y, z, 0.5f * glow * red, red},
                             {corner + x, z, y, 0.5f * glow * green, green}};
  const auto ceiling = [&](float x0, float x1, float z0, float z1, const Rgb& emitted) {
    if (x0 < x1 && z0 < z1) all.push_back({{x0, h, z0}, {x1 - x0, 0, 0}, {0, 0, z1 - z0}, emitted, white});
  };
  constexpr float middle = d / 2 - 1;
  const float half = panel / 2, near = middle + half, far = middle - half;
  const Rgb dim = 0.5f * glow * white;
  ceiling(-half, half, far, near, 6 / (panel * panel) * white);
  ceiling(-w, w, -1, far, dim);
  ceiling(-w, w, near, d - 1, dim);
  ceiling(-w, -half, far, near, dim);
  ceiling(half, w, far, near, dim);
  return all;
}

// A box on the floor, turned about the vertical through its middle.
std::vector<Rectangle> box_faces(int box, const vec3& middle, const vec3& half, float degrees, float glow) {
  const Rgb white(0.73f);
  const float angle = degrees * pi / 180;
  const vec3 a = half.x * vec3(math::cos(angle), 0, -math::sin(angle)),
             c = half.z * vec3(math::sin(angle), 0, math::cos(angle)), y(0, 2 * half.y, 0);
  std::vector<Rectangle> faces{{middle - a - c + y, 2.0f * c, 2.0f * a, 0.4f * glow * white, white, box}};
  for (const auto& [out, along] : {std::pair{a, -c}, {-a, c}, {c, a}, {-c, -a}})
    faces.push_back({middle + out - along, 2.0f * along, y, 0.2f * glow * white, white, box});
  return faces;
}

struct GlowingRoomParams {
  float panel = 1;
  float walls = 1;
};

template <class Visitor>
void describe(Visitor& v, GlowingRoomParams& p) {
  v.number("panel", p.panel, 0.05, 2, "m", "side of the bright square of the ceiling, of the same power at any size");
  v.number("walls", p.walls, 0, 10, "1", "times their glow: of all but that square, the boxes' too");
}

Scene make_glowing_room(const GlowingRoomParams& params) {
  std::vector<Rectangle> rectangles = walls(params.panel, params.walls);
  for (const Rectangle& r : box_faces(0, {-0.38f, 0, -0.35f}, {0.28f, 0.6f, 0.28f}, 18, params.walls)) rectangles.push_back(r);
  for (const Rectangle& r : box_faces(1, {0.4f, 0, 0.3f}, {0.28f, 0.28f, 0.28f}, -17, params.walls)) rectangles.push_back(r);
  // Half way between the boxes' middles.
  const dvec3 across = glm::normalize(dvec3(0.78, 0, 0.65));
  auto room = std::make_shared<GlowingRoom>(CutPlane{across, glm::dot(across, dvec3(0.01, 0, -0.025))});
  ExactStage s("builtin:glowing-room");
  for (const Rectangle& r : rectangles) {
    const dvec3 a(r.corner), u(r.u), v(r.v);
    const Face face{{a, a + u, a + u + v, a + v}, glm::normalize(glm::cross(u, v)), r.emitted, r.albedo, r.box};
    room->add(face);
    s.glowing_reflector(quad(r.corner, r.corner + r.u, r.corner + r.u + r.v, r.corner + r.v),
                        s.builder.material(Diffuse{r.albedo}), r.emitted, [room, face](const dvec3& p) {
                          return dvec3(face.emitted) + dvec3(face.albedo) / std::numbers::pi * room->irradiance(p, face);
                        });
  }
  s.builder.max_depth(1);
  s.builder.camera({0, 1.05f, 1.55f}, {0, 0.75f, -0.5f}, 68, {128, 128});
  return s.finish("what is seen of each rectangle: E = L/2 sum theta_i (Gamma_i . n); light is reflected once");
}

}  // namespace

std::vector<BuiltinScene> glowing_room_scenes() {
  return {
      with_params<make_glowing_room>("glowing-room", "exact: a room of glowing walls and two boxes, for irradiance caches")};
}

}  // namespace etendue
