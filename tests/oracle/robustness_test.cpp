// Many rays at the vertices and edges of a closed mesh, near and far, at several scales: every structure finds the same
// surface, and none lets a ray out.
#include "accel/exact/exact.h"
#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>

namespace etendue::testing {
namespace {

constexpr std::size_t batch_size = 4096;

struct Placement {
  const char* name;
  float scale;
  vec3 offset;
};
constexpr Placement placements[] = {{"at the origin", 1, vec3(0)},
                                    {"1e6 away", 64, vec3(1e6f, -1e6f, 1e6f)},  // coordinates there are 1/16 apart
                                    {"scaled by 2^20", 0x1p20f, vec3(0)},
                                    {"scaled by 2^-20", 0x1p-20f, vec3(0)}};

// A sphere with bumps, closed and star-shaped about its centre; 40,000 triangles at 100 rings.
Scene bumpy_sphere(const Placement& placement, int rings) {
  Geometry g = closed_sphere(rings, 2 * rings);
  for (vec3& p : g.positions) {
    const float radius = 1 + 0.15f * std::sin(9 * p.x) * std::sin(7 * p.y + 1) * std::sin(8 * p.z + 2);
    p = placement.scale * (radius * p) + placement.offset;
  }
  return scene_of(std::move(g));
}

// A point of a random triangle: a vertex, a point of an edge, or one inside, in turn.
vec3 target(const Geometry& g, Random& random, std::size_t turn) {
  const uvec3 v = g.triangles[random.below(static_cast<std::uint32_t>(g.triangles.size()))];
  const vec3 &a = g.positions[v.x], &b = g.positions[v.y], &c = g.positions[v.z];
  const float s = random.unit(), t = random.unit();
  if (turn % 3 == 0) return a;
  if (turn % 3 == 1) return a + s * (b - a);
  return a + (s + t > 1 ? 1 - s : s) * (b - a) + (s + t > 1 ? 1 - t : t) * (c - a);
}

// Rays from inside, from close by and from up to a thousand times the mesh's size away.
std::vector<Ray> rays_at(const Scene& scene, const Placement& placement, std::uint64_t seed) {
  Random random(seed);
  std::vector<Ray> rays(batch_size);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const float distances[] = {0.5f, 2, 2, std::exp2(random.between(0, 10))};
    const vec3 origin = placement.offset + placement.scale * distances[random.below(4)] * random.in_cube(1);
    rays[i] = {origin, 0, target(scene.objects[0].geometry, random, i) - origin, infinity};
    if (i % 4 == 0) rays[i].direction = glm::normalize(rays[i].direction);
    if (i % 16 == 5) {  // straight along an axis at the target
      const int axis = static_cast<int>(random.below(3));
      rays[i].origin = rays[i].origin + rays[i].direction;
      rays[i].direction = vec3(random.unit() < 0.5f ? 0.0f : -0.0f);
      rays[i].direction[axis] = random.unit() < 0.5f ? 1.0f : -1.0f;
      rays[i].origin[axis] -= 3 * placement.scale * rays[i].direction[axis];
    }
  }
  return rays;
}

struct Structure {
  std::string label;
  std::unique_ptr<RayQuery> query;
  std::atomic<std::uint64_t> rounding = 0, wrong = 0;  // of rays on which it differs from the first
};

// Our structures, in each layout, but for those that look at all triangles.
std::vector<std::unique_ptr<Structure>> structures_over(const Scene& scene) {
  std::vector<std::unique_ptr<Structure>> all;
  const auto add = [&](const RayEntry& entry, const ParamMap& params, const std::string& label) {
    all.push_back(std::make_unique<Structure>());
    all.back()->label = label;
    all.back()->query = entry.make(scene, params);
  };
  for (const RayEntry& entry : ray_structures()) {
    if (is_adapter(entry.name) || entry.name == "brute" || entry.name == "bounds") continue;
    add(entry, {}, entry.name);
    for (const ParamInfo& info : entry.params)
      for (const char* layout : {"bvh4", "bvh8", "bvh16"})
        if (info.name == "layout" && info.range.find(layout) != std::string::npos)
          add(entry, {{"layout", {std::string(layout), {}}}}, entry.name + " " + layout);
  }
  return all;
}

class Agreement {
 public:
  Agreement(const Scene& scene, const Placement& placement)
      : scene_(scene), placement_(placement), structures_(structures_over(scene)) {}

  void try_batch(std::uint64_t seed) {
    const std::vector<Ray> rays = rays_at(scene_, placement_, seed);
    std::vector<Hit> expected(rays.size()), hits(rays.size());
    structures_[0]->query->closest(rays, expected);
    for (const auto& structure : structures_) {
      structure->query->closest(rays, hits);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const bool occluded = i % 4 > 0 ? static_cast<bool>(expected[i]) : structure->query->occluded(rays[i]);
        if (hits[i].primitive == expected[i].primitive && hits[i].t == expected[i].t &&
            occluded == static_cast<bool>(expected[i]))
          continue;
        judge(*structure, rays[i], hits[i], expected[i], occluded);
      }
    }
  }

  void expect_none_wrong() const {
    for (const auto& structure : structures_) {
      EXPECT_EQ(structure->wrong, 0u) << structure->label << ", " << placement_.name;
      if (structure->rounding > 0)
        std::printf("%s, %s: %lu differences of rounding\n", structure->label.c_str(), placement_.name,
                    structure->rounding.load());
    }
  }

 private:
  void judge(Structure& structure, const Ray& ray, const Hit& hit, const Hit& expected, bool occluded) {
    const auto exact = exact_closest(scene_, ray);
    if (!is_right(scene_, ray, expected, exact)) ++structures_[0]->wrong;
    const bool right = is_right(scene_, ray, hit, exact) && occluded == static_cast<bool>(hit);
    ++(right ? structure.rounding : structure.wrong);
    if (right || structure.wrong > 3) return;
    const std::scoped_lock lock(mutex_);
    std::printf("%s, %s: (%a, %a, %a) + t (%a, %a, %a): %u at %a, %s %u at %a, exactly %u at %a\n", structure.label.c_str(),
                placement_.name, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z,
                hit.primitive, hit.t, structures_[0]->label.c_str(), expected.primitive, expected.t,
                exact ? exact->primitive : no_id, exact ? exact->t : 0.0);
  }

  const Scene& scene_;
  const Placement& placement_;
  std::vector<std::unique_ptr<Structure>> structures_;
  std::mutex mutex_;
};

void try_agreement(std::size_t rays, int rings) {
  for (const Placement& placement : placements) {
    const Scene scene = bumpy_sphere(placement, rings);
    Agreement agreement(scene, placement);
    const std::size_t batches = rays / std::size(placements) / batch_size + 1;
    parallel_for(batches, 1, [&](std::size_t batch) { agreement.try_batch(batch); });
    agreement.expect_none_wrong();
  }
}

// Counts rays that get out from inside, where the mesh shuts everything in.
std::uint64_t leaks(const RayQuery& structure, const Scene& scene, const Placement& placement, std::size_t rays) {
  std::atomic<std::uint64_t> leaks = 0;
  parallel_for(rays / batch_size + 1, 1, [&](std::size_t batch) {
    Random random(batch);
    std::vector<Ray> inside(batch_size);
    std::vector<Hit> hits(batch_size);
    for (std::size_t i = 0; i < inside.size(); ++i) {
      const vec3 origin = placement.offset + placement.scale * random.in_cube(0.4f);
      inside[i] = {origin, 0, target(scene.objects[0].geometry, random, i) - origin, infinity};
    }
    structure.closest(inside, hits);
    for (const Hit& hit : hits) leaks += !hit;
  });
  return leaks;
}

std::uint64_t wide_leaks(std::size_t rays, int rings) {
  const Scene scene = bumpy_sphere(placements[0], rings);
  const auto structure = find_ray_structure("binned-sah", {}).make(scene, {{"layout", {std::string("bvh16"), {}}}});
  return leaks(*structure, scene, placements[0], rays);
}

TEST(Robustness, StructuresAgreeOnRaysAtVerticesAndEdgesAtAllScales) { try_agreement(100'000, 40); }

TEST(Robustness, NoneOfAMillionRaysLeavesAClosedMesh) { EXPECT_EQ(wide_leaks(1'000'000, 100), 0u); }

TEST(LongRobustness, StructuresAgreeOnTenMillionRaysAtAllScales) { try_agreement(10'000'000, 100); }

TEST(LongRobustness, NoneOfAHundredMillionRaysLeavesAClosedMesh) { EXPECT_EQ(wide_leaks(100'000'000, 100), 0u); }

}  // namespace
}  // namespace etendue::testing
