#include "tests/oracle/ray_cases.h"

namespace etendue::testing {

namespace {

Geometry soup(Random& random, int count, float size, const vec3& offset = vec3(0)) {
  Geometry g;
  for (int i = 0; i < count; ++i) {
    const vec3 centre = offset + random.in_cube(1);
    add_triangle(g, centre + random.in_cube(size), centre + random.in_cube(size), centre + random.in_cube(size));
  }
  return g;
}

// Long thin triangles along the diagonal: their boxes overlap almost wholly.
Geometry slivers(Random& random, int count) {
  Geometry g;
  for (int i = 0; i < count; ++i) {
    const vec3 start = vec3(-1) + random.in_cube(0.3f), end = vec3(1) + random.in_cube(0.3f);
    add_triangle(g, start, end, end + random.in_cube(1e-3f));
  }
  return g;
}

Geometry coincident_centroids(Random& random, int count) {
  Geometry g;
  for (int i = 0; i < count; ++i) {
    const vec3 a = random.in_cube(1), b = random.in_cube(1);
    add_triangle(g, a, b, -(a + b));
  }
  return g;
}

Geometry pile_of_equals(int count) {
  Geometry g;
  for (int i = 0; i < count; ++i) add_triangle(g, {-1, -1, 0.5f}, {1, -1, 0.5f}, {0, 1, -0.5f});
  return g;
}

void add_quad(Geometry& g, const vec3& corner, const vec3& u, const vec3& v) {
  add_triangle(g, corner, corner + u, corner + u + v);
  add_triangle(g, corner, corner + u + v, corner + v);
}

Geometry teapot_in_stadium() {
  Geometry g = closed_sphere(24, 48);
  for (vec3& p : g.positions) p = 0.01f * p + vec3(3, 0.01f, -2);
  add_quad(g, {-100, 0, -100}, {200, 0, 0}, {0, 0, 200});
  add_quad(g, {-100, 0, 100}, {200, 0, 0}, {0, 80, 0});
  return g;
}

// Axis-parallel squares on a lattice, whose boxes have no extent along one axis and touch their neighbours'.
Geometry flat_squares() {
  Geometry g;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j < 2; ++j)
        for (int k = -2; k < 2; ++k) {
          vec3 corner(0), u(0), v(0);
          corner[axis] = 0.5f * i;
          corner[(axis + 1) % 3] = 0.5f * j;
          corner[(axis + 2) % 3] = 0.5f * k;
          u[(axis + 1) % 3] = v[(axis + 2) % 3] = 0.5f;
          add_quad(g, corner, u, v);
        }
  return g;
}

Geometry with_invalid_triangles(Random& random) {
  Geometry g = soup(random, 200, 0.2f);
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  add_triangle(g, {nan, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add_triangle(g, {0, 0, 0}, {infinity, 0, 0}, {0, 1, 0});
  add_triangle(g, {0, -infinity, 0}, {1, 0, 0}, {0, 1, nan});
  add_triangle(g, {0, 0, 0}, {1, 1, 1}, {2, 2, 2});                             // a line
  add_triangle(g, {0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f});  // a point
  return g;
}

// Each triangle half the size of the one before and as much nearer to a point: the tree of least area is a chain.
Geometry geometric_series() {
  Geometry g;
  for (int i = 0; i < 120; ++i) {
    const float s = std::ldexp(1.0f, -i);
    add_triangle(g, {s, 0, 0}, {s, s, 0}, {s, 0, s});
  }
  return g;
}

Geometry quadrics_and_triangles(Random& random) {
  Geometry g = soup(random, 60, 0.3f);
  for (int i = 0; i < 20; ++i) g.quadrics.push_back(Sphere{random.in_cube(1), random.between(0.05f, 0.3f)});
  for (int i = 0; i < 10; ++i)
    g.quadrics.push_back(
        Cylinder{random.in_cube(1), random.between(0.05f, 0.2f), random.direction(), random.between(0.1f, 0.8f), i % 2 == 0});
  for (int i = 0; i < 10; ++i) g.quadrics.push_back(Disk{random.in_cube(1), 0.4f, random.direction(), i % 2 ? 0.1f : 0.0f});
  g.quadrics.push_back(Sphere{{0, 0, 0}, 0});  // of no size
  return g;
}

Transform from_linear(const mat3& linear, const vec3& offset) {
  mat4 m(linear);
  m[3] = vec4(offset, 1);
  return *Transform::from_matrix(m);
}

// Mirrored, sheared, unevenly scaled and rotated copies of two objects, an object of invalid triangles alone, and the world's
// own.
Scene instances(Random& random) {
  Scene scene = scene_of(soup(random, 40, 0.3f));
  scene.objects.resize(4);
  scene.objects[1].geometry = closed_sphere(8, 16);
  scene.objects[2].geometry = quadrics_and_triangles(random);
  add_triangle(scene.objects[3].geometry, {0, 0, 0}, {1, 1, 1}, {2, 2, 2});
  for (std::uint32_t i = 0; i < 30; ++i) {
    mat3 linear(glm::mat3(0.3f));
    if (i % 3 == 0) linear[0] = -linear[0];
    if (i % 3 == 1) linear[1] += random.in_cube(0.5f);
    if (i % 3 == 2) linear = mat3(vec3(0.05f, 0, 0), vec3(0, 0.8f, 0), vec3(0, 0, 0.3f));
    const Transform turned = Transform::rotate(random.between(0, 6), random.direction()) * from_linear(linear, vec3(0));
    scene.instances.push_back({1 + i % 3, Transform::translate(random.in_cube(1.5f)) * turned});
  }
  return scene;
}

}  // namespace

void add_triangle(Geometry& geometry, const vec3& a, const vec3& b, const vec3& c) {
  const auto first = static_cast<std::uint32_t>(geometry.positions.size());
  geometry.positions.insert(geometry.positions.end(), {a, b, c});
  geometry.triangles.push_back({first, first + 1, first + 2});
}

Scene scene_of(Geometry geometry) {
  Scene scene;
  scene.objects[0].geometry = std::move(geometry);
  return scene;
}

Geometry closed_sphere(int rings, int sectors) {
  Geometry g;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const float theta = pi * static_cast<float>(i) / static_cast<float>(rings);
      const float phi = 2 * pi * static_cast<float>(j) / static_cast<float>(sectors);
      // The poles are single points, so that no gap opens between their triangles.
      g.positions.push_back(i == 0 ? vec3(0, 0, 1)
                            : i == rings
                                ? vec3(0, 0, -1)
                                : vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(i * sectors + j % sectors); };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) g.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
      if (i < rings - 1) g.triangles.push_back({vertex(i, j + 1), vertex(i + 1, j), vertex(i + 1, j + 1)});
    }
  return g;
}

std::vector<RayCase> ray_cases() {
  Random random(7);
  std::vector<RayCase> cases;
  cases.push_back({"empty", Scene()});
  Geometry one;
  add_triangle(one, {-1, -1, 0}, {1, -1, 0}, {0, 1, 0.3f});
  cases.push_back({"one triangle", scene_of(one)});
  cases.push_back({"soup", scene_of(soup(random, 400, 0.2f))});
  cases.push_back({"slivers", scene_of(slivers(random, 300))});
  cases.push_back({"coincident centroids", scene_of(coincident_centroids(random, 200))});
  cases.push_back({"pile of equals", scene_of(pile_of_equals(200))});
  cases.push_back({"teapot in a stadium", scene_of(teapot_in_stadium())});
  cases.push_back({"flat squares", scene_of(flat_squares())});
  cases.push_back({"invalid triangles", scene_of(with_invalid_triangles(random))});
  cases.push_back({"geometric series", scene_of(geometric_series())});
  cases.push_back({"far from the origin", scene_of(soup(random, 200, 20, vec3(1e6f, -1e6f, 1e6f)))});
  cases.push_back({"closed sphere", scene_of(closed_sphere(12, 24))});
  cases.push_back({"quadrics", scene_of(quadrics_and_triangles(random))});
  cases.push_back({"instances", instances(random)});
  RayCase planes{"planes", scene_of(soup(random, 50, 0.3f))};
  planes.scene.planes = {
      {{0, 0, -1.2f}, {0, 0, 1}}, {{1.5f, 0, 0}, glm::normalize(vec3(-1, 0.2f, 0.1f))}, {{0, 0, -1.2f}, {0, 0, -1}}};
  cases.push_back(planes);
  RayCase both{"instances and planes", instances(random)};
  both.scene.planes = planes.scene.planes;
  cases.push_back(both);
  RayCase planes_alone{"planes alone", Scene()};
  planes_alone.scene.planes = planes.scene.planes;
  cases.push_back(planes_alone);
  return cases;
}

namespace {

// The box that rays of a scene come from and go to.
Bounds surroundings(const Scene& scene) {
  Bounds b = scene.bounds();
  if (b.empty() || !is_finite(b.lower) || !is_finite(b.upper)) b = {vec3(-1), vec3(1)};
  return b;
}

vec3 point_in(Random& random, const Bounds& b, float enlarged) {
  const vec3 half = 0.5f * b.diagonal() * enlarged;
  return b.centre() + vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)) * half;
}

// Three vertices of a random valid triangle in world space.
bool random_triangle(const Scene& scene, Random& random, vec3 (&p)[3]) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    const Instance& instance = scene.instances[random.below(static_cast<std::uint32_t>(scene.instances.size()))];
    const Geometry& g = scene.objects[instance.object].geometry;
    if (g.triangles.empty()) continue;
    const std::uint32_t id = random.below(static_cast<std::uint32_t>(g.triangles.size()));
    if (!g.is_valid(id)) continue;
    for (int i = 0; i < 3; ++i) p[i] = instance.to_world.point(g.positions[g.triangles[id][i]]);
    return true;
  }
  return false;
}

}  // namespace

std::vector<Ray> general_rays(const Scene& scene, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const Bounds bounds = surroundings(scene);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    Ray ray{point_in(random, bounds, 2.5f), 0, random.direction(), infinity};
    switch (rays.size() % 5) {
      case 0:
        ray.direction = glm::normalize(point_in(random, bounds, 1) - ray.origin);
        break;
      case 1:  // along an axis, with zeros of either sign
        ray.direction = vec3(random.unit() < 0.5f ? 0.0f : -0.0f, random.unit() < 0.5f ? 0.0f : -0.0f, -0.0f);
        ray.direction[static_cast<int>(random.below(3))] = random.unit() < 0.5f ? 1.0f : -1.0f;
        ray.origin = point_in(random, bounds, 1.0f);
        break;
      case 2:
        ray.direction *= random.between(1e-3f, 1e3f);
        break;
      case 3:  // in an axis plane, and limited
        ray.direction[static_cast<int>(random.below(3))] = 0;
        ray.t_min = random.between(0, 0.3f) * glm::length(bounds.diagonal());
        ray.t_max = ray.t_min + random.between(0, 1) * glm::length(bounds.diagonal());
        break;
      default:
        break;
    }
    if (ray.direction != vec3(0)) rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> aimed_rays(const Scene& scene, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const Bounds bounds = surroundings(scene);
  std::vector<Ray> rays;
  vec3 p[3];
  while (rays.size() < count && random_triangle(scene, random, p)) {
    Ray ray{point_in(random, bounds, 2.0f), 0, random.direction(), infinity};
    const float s = random.unit();
    const vec3 target = rays.size() % 3 == 0   ? p[0]
                        : rays.size() % 3 == 1 ? p[0] + s * (p[1] - p[0])
                                               : (p[0] + p[1] + p[2]) / 3.0f;
    if (rays.size() % 3 == 2)
      ray.origin = target;  // on the face, give or take rounding
    else
      ray.direction = target - ray.origin;
    if (rays.size() % 7 == 0) {  // from straight above a vertex or edge
      ray.origin = target;
      const int axis = static_cast<int>(random.below(3));
      ray.direction = vec3(0);
      ray.direction[axis] = random.unit() < 0.5f ? 1.0f : -1.0f;
      ray.origin[axis] -= ray.direction[axis] * max_component(bounds.diagonal());
    }
    if (ray.direction != vec3(0)) rays.push_back(ray);
  }
  return rays;
}

}  // namespace etendue::testing
