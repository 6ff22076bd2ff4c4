// Meshes that no one would model, in every ray structure and layout: random bits, coincident, collinear, geometric series, of
// none to some hundred triangles. Nothing may crash, hang or miss a primitive, and all of it within a stack of 256 KiB.
#include "accel/exact/exact.h"
#include "accel/kernels/primitive_test.h"
#include "accel/registry.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <bit>
#include <chrono>
#include <cstring>

namespace etendue::testing {
namespace {

// Runs the work in a thread of 256 KiB of stack.
template <class Work>
void with_small_stack(const Work& work) {
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 256 * 1024), 0);
  const auto run = [](void* argument) -> void* {
    (*static_cast<const Work*>(argument))();
    return nullptr;
  };
  pthread_t thread;
  ASSERT_EQ(pthread_create(&thread, &attributes, run, const_cast<Work*>(&work)), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

class Garbage {
 public:
  explicit Garbage(std::uint64_t seed) : random_(seed) {}

  Geometry mesh() {
    static constexpr std::uint32_t counts[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 40, 100, 200};
    const std::uint32_t count = counts[random_.below(std::size(counts))], kind = random_.below(9);
    const vec3 point = any_vertex(), along = random_.in_cube(1);
    const float scale = std::exp2(random_.between(-100, 100));
    Geometry g;
    for (std::uint32_t i = 0; i < count; ++i) {
      vec3 v[3];
      for (int k = 0; k < 3; ++k) v[k] = vertex(kind, i, k, point, along, scale);
      add_triangle(g, v[0], v[1], v[2]);
    }
    if (kind == 8)
      for (std::uint32_t i = 0; i < count / 4; ++i) g.quadrics.push_back(quadric());
    return g;
  }

  Random& random() { return random_; }

 private:
  float any_float() { return std::bit_cast<float>(random_.below(1u << 16) << 16 | random_.below(1u << 16)); }
  vec3 any_vertex() { return {any_float(), any_float(), any_float()}; }
  float any_scale() { return std::exp2(random_.between(-149, 127)); }

  vec3 vertex(std::uint32_t kind, std::uint32_t i, int k, const vec3& point, const vec3& along, float scale) {
    switch (kind) {
      case 0:  // random bits
        return any_vertex();
      case 1:  // finite, of any size
        return random_.in_cube(any_scale());
      case 2:  // coincident, but for a few
        return random_.below(8) > 0 ? point : random_.in_cube(1);
      case 3:  // collinear, but for rounding
        return scale * random_.between(-1, 1) * along;
      case 4:  // geometric series
        return std::ldexp(1.0f, -static_cast<int>(i)) * vec3(1 + k % 2, 1 + k / 2, random_.unit());
      case 5:  // on a coarse lattice: flat, parallel to the axes, equal
        return vec3(random_.below(3), random_.below(3), random_.below(3));
      case 6:  // ordinary, with garbage among it
        return random_.below(12) > 0 ? random_.in_cube(1) : any_vertex();
      case 7:  // ordinary, but very large or very small
        return scale * random_.in_cube(1);
      default:  // piles of equal triangles
        return vec3(k == 0, k == 1, k == 2) + vec3(i % 3 == 0 ? 1.0f : 0.0f);
    }
  }

  Quadric quadric() {
    const float radius = random_.below(2) ? any_float() : random_.unit();
    const vec3 centre = random_.below(2) ? any_vertex() : random_.in_cube(1);
    switch (random_.below(3)) {
      case 0:
        return Sphere{centre, radius};
      case 1:
        return Cylinder{centre, radius, random_.direction(), any_float(), random_.below(2) == 0};
      default:
        return Disk{centre, radius, random_.direction()};
    }
  }

  Random random_;
};

struct Structure {
  std::string label;
  const RayEntry* entry;
  ParamMap params;
};

// Each structure as it comes, and each builder in each of its layouts.
std::vector<Structure> structures() {
  std::vector<Structure> all;
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.available || entry.name == "brute") continue;
    all.push_back({entry.name, &entry, {}});
    for (const ParamInfo& info : entry.params) {
      if (info.name != "layout") continue;
      for (const char* layout : {"bvh4", "bvh8", "bvh16"})
        if (info.range.find(layout) != std::string::npos)
          all.push_back({entry.name + " " + layout, &entry, {{"layout", {std::string(layout), {}}}}});
    }
  }
  return all;
}

// Straight at some of the valid triangles, from about their own size away; and anywhere. Directions are of ordinary length: the
// garbage is to be the mesh's.
std::vector<Ray> rays_at(const Geometry& g, Random& random) {
  std::vector<Ray> rays;
  for (std::uint32_t id = 0; id < g.triangles.size(); id += 1 + static_cast<std::uint32_t>(g.triangles.size()) / 24) {
    if (!g.is_valid(id)) continue;
    const uvec3 v = g.triangles[id];
    const dvec3 a(g.positions[v.x]), b(g.positions[v.y]), c(g.positions[v.z]), centre = a / 3.0 + b / 3.0 + c / 3.0;
    const double size = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
    const dvec3 across = glm::normalize(glm::cross((b - a) / size, (c - a) / size)) * size;
    const vec3 origins[] = {vec3(centre + across), vec3(centre - 0.5 * across + 0.25 * (b - a)), random.in_cube(2)};
    for (const vec3& origin : origins) rays.push_back({origin, 0, vec3(glm::normalize(centre - dvec3(origin))), infinity});
    rays.push_back({vec3(centre), 0, vec3(across / size), infinity});
  }
  std::erase_if(rays, [](const Ray& ray) { return !is_finite(ray.direction); });
  for (int i = 0; i < 4; ++i) rays.push_back({random.in_cube(3), 0, random.direction(), infinity});
  return rays;
}

std::string to_text(const Ray& ray) {
  char text[200];
  std::snprintf(text, sizeof text, "(%a, %a, %a) + t (%a, %a, %a)", ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                ray.direction.y, ray.direction.z);
  return text;
}

// Is the triangle too large for intersect_triangle? Where the numerator of its t is beyond the range of float, no hit comes of
// it.
bool is_beyond_float(const Ray& ray, const Geometry& g, const uvec3& corners) {
  const TriangleRay shear(ray.direction);
  float x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    const vec3 p = g.positions[corners[i]] - ray.origin;
    x[i] = p[shear.kx] - shear.sx * p[shear.kz];
    y[i] = p[shear.ky] - shear.sy * p[shear.kz];
    z[i] = shear.sz * p[shear.kz];
  }
  const auto edges = [&](auto number) {
    using Number = decltype(number);
    const auto edge = [&](int i, int j) { return static_cast<float>(Number(x[i]) * y[j] - Number(y[i]) * x[j]); };
    return vec3(edge(2, 1), edge(0, 2), edge(1, 0));
  };
  vec3 e = edges(0.0f);
  if (e.x == 0 || e.y == 0 || e.z == 0) e = edges(0.0);
  return !std::isfinite(e.x * z[0] + e.y * z[1] + e.z * z[2]);
}

// The scene without the triangles that no structure can hit, brute force included. Ids stay.
Scene within_float(Scene scene, const Ray& ray) {
  Geometry& g = scene.objects[0].geometry;
  for (uvec3& corners : g.triangles)
    if (is_beyond_float(ray, g, corners)) corners = uvec3(corners.x);
  return scene;
}

// Does the ray meet the box in double precision?
bool meets(const Ray& ray, const Bounds& box) {
  double entry = ray.t_min, exit = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = ray.origin[axis], direction = ray.direction[axis];
    const double lower = box.lower[axis] - origin, upper = box.upper[axis] - origin;
    if (direction == 0 && (lower > 0 || upper < 0)) return false;
    if (direction == 0) continue;
    entry = std::max(entry, std::min(lower / direction, upper / direction));
    exit = std::min(exit, std::max(lower / direction, upper / direction));
  }
  return entry <= exit;
}

// Holds what a structure answers for a ray.
struct Answer {
  Hit hit;
  bool occluded;
};

Answer ask(const RayQuery& structure, const Ray& ray) { return {structure.closest(ray), structure.occluded(ray)}; }

// Ours give what brute force gives, to the bit, unless rounding (products of very small or very large coordinates) moved a hit
// of brute force out of the box of its primitive: then double precision decides, and where that finds brute force itself wrong,
// nobody can be right. Double precision must not ask for a triangle beyond float, though: brute force may be right by rounding,
// at a triangle that the ray misses, where a structure rightly goes past it and on to one that single precision cannot hit.
bool loses_nothing(const Scene& scene, const Ray& ray, const Answer& answer, const Hit& expected) {
  const auto& [hit, occluded] = answer;
  const bool found = static_cast<bool>(expected);
  if (hit.primitive == expected.primitive && hit.t == expected.t && occluded == found) return true;
  const Scene possible = within_float(scene, ray);
  const auto exact = exact_closest(possible, ray);
  if (!is_right(possible, ray, expected, exact)) return true;
  if (!is_right(possible, ray, hit, exact)) return false;
  return occluded == found || (found && !exact && !meets(ray, scene.objects[0].geometry.primitive_bounds(expected.primitive)));
}

void expect_found(const Scene& scene, const RayQuery& structure, const Hit& expected, const Ray& ray) {
  const Answer answer = ask(structure, ray);
  EXPECT_TRUE(loses_nothing(scene, ray, answer, expected))
      << to_text(ray) << " hits " << answer.hit.primitive << " at " << answer.hit.t << (answer.occluded ? "" : ", not occluded")
      << ", brute force " << expected.primitive << " at " << expected.t;
}

void try_garbage(std::size_t meshes, std::uint64_t seed) {
  const std::vector<Structure> all = structures();
  const RayEntry& brute = find_ray_structure("brute", {});
  Garbage garbage(seed);
  for (std::size_t i = 0; i < meshes && !::testing::Test::HasFailure(); ++i) {
    const Scene scene = scene_of(garbage.mesh());
    const auto expected = brute.make(scene, {});
    const std::vector<Ray> rays = rays_at(scene.objects[0].geometry, garbage.random());
    std::vector<Hit> hits(rays.size());
    expected->closest(rays, hits);
    for (const Structure& structure : all) {
      SCOPED_TRACE(structure.label + ", mesh " + std::to_string(i));
      const auto start = std::chrono::steady_clock::now();
      const auto built = structure.entry->make(scene, structure.params);
      for (std::size_t k = 0; k < rays.size(); ++k) {
        if (!is_adapter(structure.entry->name)) {
          expect_found(scene, *built, hits[k], rays[k]);
        } else {  // other libraries need only survive
          built->closest(rays[k]);
          built->occluded(rays[k]);
        }
      }
      EXPECT_TRUE(std::isfinite(built->stats().sah_cost));
      EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5);
    }
  }
}

// Three triangles and a ray, from a mesh of random bits. The ray leaves the plane z = 0, in which the sliver lies but for
// 1e-10, and passes it by 29.8 at the distance where rounding of 1e22 (its second edge function is 1.5e14) lets single
// precision hit it. The huge one is hit in its inside, further on, but its edge functions are beyond float. The third is an
// ordinary one there.
constexpr Ray past_sliver = {
    {-0x1.46d4b8p+0f, 0x1.c4b6c4p+0f, -0x1.b568e8p-1f}, 0, {-0x1.145618p-27f, 1, -0x1.d55ce4p-25f}, infinity};

void add_sliver(Geometry& g) {
  add_triangle(g, {0x1.66adccp-7f, 0x1.3db12ap+71f, 0x1.99cb6cp-34f}, {-0x1.5d4b3ep-79f, -0x1.832ac6p-16f, 0x1.2838e2p-73f},
               {-0x1.b44748p-3f, -0x1.0d7754p+53f, 0x1.7a23dap-64f});
}

void add_huge(Geometry& g) {
  add_triangle(g, {0x1.b6809ap+126f, 0x1.4ecb5cp+46f, 0x1.1bae32p-86f}, {-0x1.83eb08p+110f, -0x1.bfe1c6p+20f, -0x1.4b4d8ap-16f},
               {0x1.0c3574p-32f, -0x1.da25cp-122f, -0x1.789a22p+91f});
}

void add_ordinary(Geometry& g) { add_triangle(g, {-2e9f, 1.2e9f, -1e9f}, {2e9f, 1.2e9f, -1e9f}, {0, 1.2e9f, 2e9f}); }

TEST(GarbageMeshes, HitsByRoundingAloneAreOwedByNoStructure) {
  Geometry mesh;
  add_sliver(mesh);
  add_huge(mesh);
  const Scene scene = scene_of(mesh);
  const Hit brute = find_ray_structure("brute", {}).make(scene, {})->closest(past_sliver);
  EXPECT_EQ(brute.primitive, 0u);
  EXPECT_EQ(exact_closest(scene, past_sliver)->primitive, 1u);
  EXPECT_FALSE(exact_closest(within_float(scene, past_sliver), past_sliver));
  for (const Structure& structure : structures()) {
    SCOPED_TRACE(structure.label);
    if (is_adapter(structure.entry->name)) continue;
    expect_found(scene, *structure.entry->make(scene, structure.params), brute, past_sliver);
  }
}

TEST(GarbageMeshes, LosingATriangleWithinFloatIsCaught) {
  Geometry mesh;
  add_sliver(mesh);
  add_huge(mesh);
  add_ordinary(mesh);
  const Scene scene = scene_of(mesh);
  const Hit brute = find_ray_structure("brute", {}).make(scene, {})->closest(past_sliver);
  EXPECT_EQ(brute.primitive, 0u);
  EXPECT_FALSE(loses_nothing(scene, past_sliver, {Hit{}, false}, brute));
  for (const Structure& structure : structures()) {
    SCOPED_TRACE(structure.label);
    if (is_adapter(structure.entry->name)) continue;
    const Answer answer = ask(*structure.entry->make(scene, structure.params), past_sliver);
    EXPECT_TRUE(loses_nothing(scene, past_sliver, answer, brute)) << answer.hit.primitive << " at " << answer.hit.t;
    EXPECT_FALSE(loses_nothing(scene, past_sliver, {answer.hit, false}, brute));
  }
}

TEST(GarbageMeshes, SlabsCrossedAlongASubnormalDirectionAreEntered) {
  Geometry mesh;
  for (const float x : {1e36f, 2e36f, 3e36f, -1e36f}) add_triangle(mesh, {x, -1, 1e-3f}, {x, 1, 1e-3f}, {x, 0, 2e-3f});
  const Scene scene = scene_of(mesh);
  const Ray ray{{0, 0, 0}, 0, {1, 0, 0x1p-129f}, infinity};  // its reciprocal is 2^129: infinite
  const Hit brute = find_ray_structure("brute", {}).make(scene, {})->closest(ray);
  EXPECT_EQ(brute.primitive, 0u);
  for (const Structure& structure : structures()) {
    SCOPED_TRACE(structure.label);
    if (is_adapter(structure.entry->name)) continue;
    expect_found(scene, *structure.entry->make(scene, structure.params), brute, ray);
  }
}

TEST(GarbageMeshes, ManyPerStructureWithinASmallStackLoseNoPrimitive) {
  with_small_stack([] { try_garbage(1500, 1); });
}

TEST(LongGarbageMeshes, TenThousandPerStructureWithinASmallStackLoseNoPrimitive) {
  with_small_stack([] { try_garbage(10000, 2); });
}

}  // namespace
}  // namespace etendue::testing
