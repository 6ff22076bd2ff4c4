// The tree over lights: its probabilities against brute force over random lights of every kind, and images by each way of
// choosing lights against each other.
#include "framework/core/sampling.h"
#include "framework/scene/builder.h"
#include "framework/transport/light_sampling.h"
#include "tests/block_agreement.h"
#include "tests/image_checks.h"

#include <cmath>
#include <set>

namespace etendue {
namespace {

using testing::params_of;
using testing::render;
using testing::RenderOptions;

// Numbers of a test's own.
struct Numbers {
  Pcg32 random;
  explicit Numbers(std::uint64_t seed) : random(seed, 1) {}
  float next(float low = 0, float high = 1) { return low + (high - low) * random.next_float(); }
  vec3 inside(float half) { return {next(-half, half), next(-half, half), next(-half, half)}; }
  vec3 direction() { return sample_unit_sphere(vec2(next(), next())); }
  Rgb colour() { return std::pow(10.0f, next(-2, 2)) * Rgb(1, next(0.5f, 1), next(0.2f, 1)); }
};

MeshData triangle(const vec3& a, const vec3& b, const vec3& c) {
  MeshData mesh;
  mesh.positions = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

Light sky(float radiance) {
  EnvironmentLight light;
  light.scale = Rgb(radiance);
  return light;
}

// `count` lights of random kinds in and about the cube [-1, 1]^3; every fourth triangle is two-sided, some spheres shine
// inward.
Scene lights_of_all_kinds(std::uint64_t seed, int count, bool infinite) {
  Numbers n(seed);
  SceneBuilder b("lights of all kinds");
  const auto black = b.material(Diffuse{Rgb(0)});
  std::vector<Emission> emissions;
  for (int i = 0; i < count; ++i) {
    const vec3 at = n.inside(1);
    const float size = 0.3f * square(n.next());
    switch (n.random.next() % 6) {
      case 0:
      case 1:
        b.mesh(triangle(at, at + size * n.direction(), at + size * n.direction()), black, n.colour());
        break;
      case 2:
        b.quadric(Sphere{at, size}, black, n.colour(), n.next() < 0.3f);
        break;
      case 3:
        b.quadric(Disk{at, size, n.direction()}, black, n.colour(), n.next() < 0.3f);
        break;
      case 4:
        b.light(PointLight{at, n.colour()});
        break;
      default: {
        const float outer = n.next(0.05f, 1.5f);
        b.light(SpotLight{at, n.direction(), n.colour(), std::cos(outer), std::cos(outer * n.next())});
      }
    }
  }
  if (infinite) {
    b.light(DirectionalLight{n.direction(), Rgb(0.5f)});
    b.light(sky(0.2f));
  }
  b.camera({0, 0, 3}, {0, 0, 0}, 60, {8, 8});
  Scene scene = b.finish();
  int triangles = 0;
  for (Light& light : scene.lights)
    if (auto* area = std::get_if<AreaLight>(&light); area && ++triangles % 4 == 0) area->two_sided = true;
  return scene;
}

// Points among the lights, far from them, in the planes of triangles and close to their edges.
vec3 test_point(const Scene& scene, Numbers& n, int i) {
  const auto& positions = scene.objects[0].geometry.positions;
  if (i % 3 == 0 || positions.empty()) return n.inside(i % 2 ? 1.0f : 30.0f);
  const std::size_t corner = n.random.next() % (positions.size() / 3) * 3;
  const vec3 p0 = positions[corner], e1 = positions[corner + 1] - p0, e2 = positions[corner + 2] - p0;
  const vec3 in_plane = p0 + n.next(-2, 3) * e1 + n.next(-2, 3) * e2;
  return i % 3 == 1 ? in_plane : in_plane + n.next(-1e-3f, 1e-3f) * n.direction();
}

TEST(LightTree, ProbabilitiesSumToOneAndChoicesHaveThem) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Scene scene = lights_of_all_kinds(seed, seed % 2 ? 7 : 60, seed % 3 == 0);
    LightSampler lights(scene);
    lights.choose_by(LightChoice::tree);
    ASSERT_EQ(lights.choice(), LightChoice::tree);
    Numbers n(seed + 100);
    for (int i = 0; i < 60; ++i) {
      const vec3 at = test_point(scene, n, i);
      double sum = 0;
      for (std::uint32_t l = 0; l < scene.lights.size(); ++l) sum += lights.choice_probability(at, l);
      // Where no light at a finite place can reach the point, their share is that of no sample.
      EXPECT_LT(sum, 1 + 1e-5) << seed << ' ' << i;
      for (int k = 0; k < 40; ++k) {
        const auto s = lights.sample(at, vec2(n.next(), n.next()));
        if (!s || !s->delta) continue;
        ASSERT_FLOAT_EQ(s->pdf_solid_angle, lights.choice_probability(at, s->light)) << seed << ' ' << i;
      }
    }
  }
}

// How often each light is chosen, for evenly spaced numbers, is its probability.
TEST(LightTree, ChoosesAsOftenAsItSays) {
  std::vector<LightTree::Emitter> emitters;
  Numbers n(3);
  for (int i = 0; i < 40; ++i) {
    const vec3 at = n.inside(1), size = 0.1f * glm::abs(n.direction());
    emitters.push_back({{at, at + size}, n.direction(), n.next(0, 1), n.next(0.1f, 1.5f), n.next(0.1f, 10), i % 3 == 0});
  }
  emitters[7].intensity = 0;
  const LightTree tree(emitters);
  for (int i = 0; i < 30; ++i) {
    const vec3 at = n.inside(2);
    constexpr int steps = 20000;
    std::vector<double> found(emitters.size(), 0);
    double none = 0;
    for (int k = 0; k < steps; ++k) {
      double u = (k + 0.5) / steps;
      const LightTree::Chosen chosen = tree.choose(at, u);
      ASSERT_TRUE(u >= 0 && u < 1);
      if (!(chosen.probability > 0)) {
        none += 1.0 / steps;
        continue;
      }
      found[chosen.light] += 1.0 / steps;
      ASSERT_EQ(chosen.probability, tree.probability(at, chosen.light));
    }
    double sum = none;
    for (std::uint32_t l = 0; l < emitters.size(); ++l) {
      EXPECT_NEAR(found[l], tree.probability(at, l), 2.0 / steps);
      sum += tree.probability(at, l);
    }
    EXPECT_NEAR(sum, 1, 2.0 / steps);
    EXPECT_EQ(tree.probability(at, 7), 0);
  }
}

// Compared with brute force: whatever light sends anything to a point, the tree may choose it there.
TEST(LightTree, LeavesOutNoLightThatSendsAnything) {
  std::size_t sent = 0, left_out = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const Scene scene = lights_of_all_kinds(seed, static_cast<int>(3 + 5 * (seed % 9)), false);
    LightSampler lights(scene), alone(scene);
    lights.choose_by(LightChoice::tree);
    alone.choose_by(LightChoice::uniform);
    Numbers n(seed + 200);
    for (int i = 0; i < 60; ++i) {
      const vec3 at = test_point(scene, n, i);
      for (std::size_t k = 0; k < 20 * scene.lights.size(); ++k) {
        const auto s = alone.sample(at, vec2(n.next(), n.next()));
        if (!s || is_black(s->radiance)) continue;
        ++sent;
        const float probability = lights.choice_probability(at, s->light);
        ASSERT_GT(probability, 0) << "seed " << seed << ", point " << i << ", light " << s->light;
      }
      for (std::uint32_t l = 0; l < scene.lights.size(); ++l) left_out += lights.choice_probability(at, l) == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(sent, 100000u);
  EXPECT_GT(left_out, 1000u);  // of those that face elsewhere
}

// Lights on one spot, on one line, and of powers that differ by any factor: the tree ends, and stays within its bits.
TEST(LightTree, IsBuiltOverAnyLights) {
  std::vector<LightTree::Emitter> emitters;
  for (int i = 0; i < 3000; ++i) {
    const vec3 at(std::pow(2.0f, -static_cast<float>(i % 100)), 0, 0);
    emitters.push_back({.bounds = {at, at}, .intensity = std::pow(2.0f, static_cast<float>(i % 60 - 30))});
  }
  const LightTree tree(emitters);
  for (const vec3& at : {vec3(0), vec3(1, 0, 0), vec3(5, 5, 5)}) {
    double sum = 0;
    for (std::uint32_t l = 0; l < emitters.size(); ++l) {
      ASSERT_GT(tree.probability(at, l), 0);
      sum += tree.probability(at, l);
    }
    EXPECT_NEAR(sum, 1, 1e-9);
  }
  double u = 0.5;
  EXPECT_EQ(LightTree().choose(vec3(0), u).probability, 0);
}

// The numbers that a float can hold are too few to choose a light of a thousand-millionth of the power, the last of `count`.
void expect_last_is_chosen(int count, bool flat) {
  SceneBuilder b("a weak light");
  const auto black = b.material(Diffuse{Rgb(0)});
  for (int i = 0; i < count; ++i) {
    const Rgb power(i + 1 < count ? 1 : static_cast<float>(count - 1) * 1e-9f);
    if (flat)
      b.mesh(triangle({-1, 1, 0}, {1, 1, 0}, {0, 1, 1}), black, power);
    else
      b.light(PointLight{{0, 1, 0}, power});
  }
  b.camera({0, 1, 3}, {0, 0, 0}, 60, {8, 8});
  const Scene scene = b.finish();
  const LightSampler lights(scene);
  constexpr int draws = 20000;
  constexpr float last = 0x1.fffffep-1f;  // beyond it lies a share of 2^-24
  const auto weak = static_cast<std::uint32_t>(count - 1);
  Numbers n(17);
  int sampled = 0, emitted = 0;
  for (int i = 0; i < draws; ++i) {
    const auto sample = lights.sample(vec3(0), vec2(last, n.next()));
    const auto ray = lights.emit(last, vec2(n.next(), n.next()), vec2(n.next(), n.next()));
    ASSERT_TRUE(sample && ray);
    sampled += sample->light == weak ? 1 : 0;
    emitted += ray->light == weak ? 1 : 0;
  }
  const double expected = draws * 1e-9 * 0x1p24;
  EXPECT_NEAR(sampled, expected, 4.5 * std::sqrt(expected)) << count << flat;
  EXPECT_NEAR(emitted, expected, 4.5 * std::sqrt(expected)) << count << flat;
}

TEST(LightTree, WeakLightsAreChosenByPowerToo) {
  for (const int count : {2, 9})
    for (const bool flat : {false, true}) expect_last_is_chosen(count, flat);
}

// A room of lights of all kinds, in front of walls, behind them and inside a sphere, and a sky.
Scene room_of_lights() {
  SceneBuilder b("room of lights");
  const auto white = b.material(Diffuse{Rgb(0.6f)});
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), white);
  b.mesh(quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2}),
         b.material(Plastic{.reflectance = {Rgb(0.3f, 0.5f, 0.7f)}, .alpha = 0.3f}));
  b.mesh(box({-1.5f, 0, -1}, {-0.7f, 1, -0.2f}), white);
  b.quadric(Sphere{{0.6f, 0.5f, 0.4f}, 0.5f}, b.material(Dielectric{.eta = 1.5f, .alpha = 0.4f}));
  const auto black = b.material(Diffuse{Rgb(0)});
  Numbers n(11);
  for (int i = 0; i < 12; ++i) {
    const vec3 at(n.next(-1.8f, 1.8f), n.next(0.3f, 2.8f), n.next(-1.8f, 1.8f));
    const Rgb colour = n.next(2, 20) * Rgb(1, n.next(0.5f, 1), n.next(0.5f, 1));
    if (i % 3 == 0) b.quadric(Sphere{at, 0.12f}, black, colour);
    if (i % 3 == 1) b.quadric(Disk{at, 0.2f, n.direction()}, black, colour);
    if (i % 3 == 2) {
      b.mesh(triangle(at, at + 0.4f * n.direction(), at + 0.4f * n.direction()), black, colour);
    }
  }
  b.light(PointLight{{-1, 2, 1}, Rgb(2)});
  b.light(SpotLight{{1.5f, 2.5f, 1}, glm::normalize(vec3(-1, -2, -1)), Rgb(8), 0.7f, 0.8f});
  b.light(DirectionalLight{glm::normalize(vec3(1, -2, -1)), Rgb(0.4f)});
  b.light(sky(0.15f));
  b.camera({0, 1.6f, 4.5f}, {0, 1, 0}, 42, {16, 16});
  Scene scene = b.finish();
  int lights = 0;
  for (Light& light : scene.lights)
    if (auto* area = std::get_if<AreaLight>(&light); area && lights++ % 2 == 0) area->two_sided = true;
  return scene;
}

TEST(LightTree, MakesTheImageThatPowerMakes) {
  const auto with = [](const char* lights, std::initializer_list<std::pair<const char*, const char*>> more = {}) {
    ParamMap params = params_of(more);
    params["max_depth"] = {std::int64_t{4}, {}};
    params["lights"] = {std::string(lights), {}};
    return params;
  };
  testing::expect_agreement(room_of_lights(), {.resolution = {12, 12}, .block = 4, .comparisons = 1},
                            {"path", with("power"), 128, 0},
                            {{"path", with("tree"), 96, 0},
                             {"path", with("uniform"), 128, 0},
                             {"path", with("auto"), 96, 0},
                             {"path", with("tree", {{"mis", "light"}}), 128, 0},
                             {"bdpt", with("tree"), 48, 0},
                             {"guided", with("tree"), 96, 0}});
}

RenderOptions small(std::uint32_t iterations, const ParamMap& params) {
  RenderOptions options;
  options.params = params;
  options.iterations = iterations;
  options.resolution = {24, 16};
  return options;
}

TEST(LightTree, SameBitsAtAnyThreadCount) {
  for (const char* method : {"path", "bdpt", "irradiance-cache"})
    testing::expect_same_bits_at_any_thread_count(load_scene("builtin:many-lights?lights=40"), method, small(2, {}));
}

// The pilot by which caches decide on a caustic map makes choices of its own, which must not take the place of theirs.
TEST(LightTree, EveryChoiceChangesTheImageOfCachesBesideGlass) {
  SceneBuilder b("lamps and a glass ball");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.6f)}));
  b.quadric(Sphere{{0, 0.5f, 0}, 0.4f}, b.material(Dielectric{.eta = 1.5f}));
  const auto black = b.material(Diffuse{Rgb(0)});
  for (int i = 0; i < 9; ++i) {
    const auto k = static_cast<float>(i);
    b.quadric(Sphere{{0.4f * k - 1.6f, 1.5f, 0.2f * k - 1}, 0.1f}, black, Rgb(5 + 3 * k));
  }
  b.camera({0, 1.6f, 4.5f}, {0, 0.5f, 0}, 42, {16, 16});
  const Scene scene = b.finish();
  for (const char* method : {"irradiance-cache", "radiance-cache", "hash-cache"}) {
    std::set<std::uint64_t> hashes;
    for (const char* lights : {"tree", "power", "uniform"}) {
      ParamMap with{{"lights", {std::string(lights), {}}}};
      if (method != std::string("hash-cache")) with["samples"] = {std::int64_t{8}, {}};
      hashes.insert(render(scene, method, small(1, with)).hash);
    }
    EXPECT_EQ(hashes.size(), 3u) << method;
  }
}

TEST(LightTree, EveryChoiceChangesTheImage) {
  const Scene scene = load_scene("builtin:many-lights?lights=9");
  const std::pair<const char*, ParamMap> methods[] = {{"path", {}},
                                                      {"bdpt", {}},
                                                      {"vcm", {}},
                                                      {"guided", {}},
                                                      {"hash-cache", {}},
                                                      {"irradiance-cache", params_of({{"samples", "8"}})},
                                                      {"radiance-cache", params_of({{"samples", "8"}})},
                                                      {"photon-cache", params_of({{"samples", "8"}, {"photons", "500"}})},
                                                      {"photon-map", params_of({{"photons", "500"}})},
                                                      {"ppm", params_of({{"photons", "500"}})},
                                                      {"sppm", params_of({{"photons", "500"}})},
                                                      {"ppm-memoryless", params_of({{"photons", "500"}})},
                                                      {"appm", params_of({{"photons", "500"}})},
                                                      {"cppm", params_of({{"photons", "500"}})}};
  for (const auto& [method, params] : methods) {
    std::set<std::uint64_t> hashes;
    for (const char* lights : {"tree", "power", "uniform"}) {
      ParamMap with = params;
      with["lights"] = {std::string(lights), {}};
      hashes.insert(render(scene, method, small(1, with)).hash);
    }
    EXPECT_EQ(hashes.size(), 3u) << method;
  }
}

// Lights that are not flat are chosen one by one in any case; those as wide as the scene are told apart by nothing.
TEST(LightTree, IsTakenWhereItTellsLightsApart) {
  for (const auto& [name, choice] : {std::pair{"builtin:veach-mis", LightChoice::tree},
                                     {"builtin:concentric-spheres", LightChoice::power},
                                     {"builtin:cornell-box", LightChoice::power},
                                     {"builtin:glowing-room", LightChoice::power},
                                     {"builtin:glowing-room?walls=0", LightChoice::power},
                                     {"builtin:many-lights?lights=40", LightChoice::tree},
                                     {"builtin:furnace", LightChoice::power},
                                     {"builtin:stadium", LightChoice::power}}) {
    const Scene scene = load_scene(name);
    LightSampler lights(scene);
    lights.choose_by(LightChoice::by_need, DirectSamples::of_both);
    EXPECT_EQ(lights.choice(), choice) << name;
  }
}

// A sky of one radiance is left to BSDF samples where the method says so, unless it is the only light or a way of choosing is
// asked for.
TEST(LightTree, EvenLightIsLeftToBsdfSamples) {
  const Scene scene = lights_of_all_kinds(3, 12, true);
  LightSampler lights(scene);
  std::uint32_t sky = 0;
  while (!std::holds_alternative<EnvironmentLight>(scene.lights[sky])) ++sky;
  const vec3 up(0, 0, 1);
  for (const LightChoice choice : {LightChoice::by_need, LightChoice::power, LightChoice::uniform, LightChoice::tree}) {
    lights.choose_by(choice);
    EXPECT_GT(lights.choice_probability(vec3(0), sky), 0);
    lights.choose_by(choice, DirectSamples::of_both);
    EXPECT_EQ(lights.choice_probability(vec3(0), sky) == 0, choice == LightChoice::by_need);
    EXPECT_EQ(lights.environment_pdf(up) == 0, choice == LightChoice::by_need);
    double sum = 0;
    for (std::uint32_t i = 0; i < scene.lights.size(); ++i) sum += lights.choice_probability(vec3(0), i);
    EXPECT_NEAR(sum, 1, 1e-5);
  }
  EXPECT_FALSE(lights.only_even());
  const Scene even = load_scene("builtin:white-furnace");
  LightSampler alone(even);
  alone.choose_by(LightChoice::by_need, DirectSamples::of_both);
  EXPECT_TRUE(alone.only_even());
  EXPECT_EQ(alone.choice_probability(vec3(0), 0), 1);
}

TEST(LightTree, IsTakenFromAFewLightsOn) {
  for (const auto& [count, taken] : {std::pair{"1", false}, {"8", false}, {"9", true}}) {
    const Scene scene = load_scene(std::string("builtin:many-lights?lights=") + count);
    const auto hash = [&](const char* lights) { return render(scene, "path", small(1, params_of({{"lights", lights}}))).hash; };
    EXPECT_EQ(hash("auto"), hash(taken ? "tree" : "power")) << count;
    EXPECT_EQ(hash("tree") == hash("power"), std::string(count) == "1") << count;
  }
}

}  // namespace
}  // namespace etendue
