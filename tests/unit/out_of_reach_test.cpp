// Light that a method leaves out or mixes up, as the warning beside its image says.
#include "integrators/warnings/out_of_reach.h"
#include "experiments/run/run_cell.h"
#include "framework/scene/builder.h"
#include "integrators/choice/choose.h"
#include "integrators/registry.h"
#include "integrators/warnings/coinciding.h"
#include "integrators/warnings/mixed_surfaces.h"
#include "integrators/warnings/seldom_lights.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

TEST(LightOutOfReach, IsToldOfMethodsThatFindItByChance) {
  const auto told = [](const std::string& scene, const std::string& method, const char* caustic_map = nullptr) {
    SceneContext stage(load_scene(scene), {64, 64}, 1);
    ParamMap params;
    if (caustic_map) params["caustic_map"] = {std::string(caustic_map), {}};
    std::string text;
    with_threads(2, [&] { text = light_out_of_reach(stage.context, method, params); });
    return text;
  };
  EXPECT_NE(told("builtin:water", "path").find("path leaves it out; cppm brings it"), std::string::npos);
  for (const char* cache : {"irradiance-cache", "radiance-cache", "hash-cache"}) {
    EXPECT_EQ(told("builtin:glass-caustic", cache), "");
    EXPECT_EQ(told("builtin:glass-caustic", cache, "on"), "");
    EXPECT_NE(told("builtin:glass-caustic", cache, "off").find("leaves it noisy; cppm brings it"), std::string::npos) << cache;
  }
  EXPECT_EQ(told("builtin:water", "cppm"), "");
  EXPECT_NE(told("builtin:veiled-lamp?seen=through,radius=0.003", "bdpt").find("vcm brings them"), std::string::npos);
  // A pilot's ray or two that met the lamp by luck do not make its caustic in the ball one that bdpt brings.
  EXPECT_NE(told("builtin:glass-caustic", "bdpt").find("vcm brings them"), std::string::npos);
  for (const char* scene : {"builtin:cornell-spheres", "builtin:veiled-lamp?radius=0.003"})
    EXPECT_EQ(told(scene, "bdpt"), "") << scene;
  EXPECT_EQ(told("builtin:thin-wall", "path"), "");    // a mirror in which paths find the light
  EXPECT_EQ(told("builtin:cornell-box", "path"), "");  // nothing specular
}

// A lamp in a ball of frosted glass: what is nearly smooth casts caustics as smooth glass does.
TEST(LightOutOfReach, IsToldOfFrostedGlassThatIsNearlySmooth) {
  const auto told = [](float alpha, const char* method, bool mirror = false) {
    SceneBuilder b("bulb");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
    b.quadric(Sphere{{0, 1, 0}, 0.001f}, b.material(Diffuse{Rgb(0)}), Rgb(1e6f));
    b.quadric(Sphere{{0, 1, 0}, 0.2f}, b.material(Dielectric{.eta = 1.5f, .alpha = alpha}));
    if (mirror) b.quadric(Sphere{{1.4f, 0.2f, -1.4f}, 0.2f}, b.material(Conductor{.ideal = true}));
    b.camera({0, 2, 3.5f}, {0, 0.3f, 0}, 50, {32, 32});
    SceneContext stage(b.finish(), {32, 32}, 1);
    std::string text;
    with_threads(2, [&] { text = light_out_of_reach(stage.context, method, {}); });
    return text;
  };
  for (const char* method : {"path", "guided", "irradiance-cache", "hash-cache"}) {
    EXPECT_NE(told(0.003f, method).find("cppm brings it"), std::string::npos) << method;
    EXPECT_EQ(told(0.5f, method), "") << method;
  }
  // A mirror gives caches a caustic map, which takes no photons from frosted glass.
  for (const char* cache : {"irradiance-cache", "radiance-cache", "hash-cache"}) {
    EXPECT_NE(told(0.003f, cache, true).find("no photons from frosted glass"), std::string::npos) << cache;
    EXPECT_EQ(told(0.5f, cache, true), "") << cache;
  }
}

// The map brings what a clear ball casts; a frosted pane that casts next to nothing changes nothing of that.
TEST(LightOutOfReach, IsNotToldOfClearGlassBesideFrostedGlass) {
  SceneBuilder b("clear and frosted");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
  b.light(PointLight{{0, 3, 0}, Rgb(10)});
  b.quadric(Sphere{{0, 0.8f, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
  b.quadric(Sphere{{30, 0.2f, -30}, 0.2f}, b.material(Dielectric{.eta = 1.5f, .alpha = 0.003f}));
  b.camera({0, 2, 3.5f}, {0, 0.3f, 0}, 50, {32, 32});
  SceneContext stage(b.finish(), {32, 32}, 1);
  for (const char* cache : {"irradiance-cache", "radiance-cache", "hash-cache"})
    EXPECT_EQ(light_out_of_reach(stage.context, cache, {}), "") << cache;
}

TEST(LightOutOfReach, IsToldOfPhotonsThatHardlyLandOnWhatIsSeen) {
  const auto told = [](const std::string& scene, const std::string& method, const ParamMap& params = {}) {
    SceneContext stage(load_scene(scene), {64, 64}, 1);
    return light_out_of_reach(stage.context, method, params);
  };
  constexpr const char* wide = "builtin:sunlit-field?surroundings=64";
  for (const char* method : {"photon-map", "sppm", "cppm", "photon-cache"}) {
    EXPECT_NE(told(wide, method).find("emission = \"visibility\" may guide them"), std::string::npos) << method;
    EXPECT_EQ(told(wide, method, {{"emission", {std::string("visibility"), {}}}}), "");
    EXPECT_NE(told("builtin:exterior", method).find("one photon in"), std::string::npos) << method;
    EXPECT_EQ(told("builtin:two-rooms", method), "") << method;
  }
  const ParamMap merging{{"neighbours", {std::int64_t{1}, {}}}};
  constexpr const char* nothing_specular = "builtin:sunlit-field?surroundings=64,veil=false";
  for (const char* method : {"vcm", "light-trace"}) EXPECT_NE(told(wide, method).find("bdpt needs none"), std::string::npos);
  EXPECT_NE(told(nothing_specular, "vcm", merging).find("bdpt needs none"), std::string::npos);
  EXPECT_EQ(told(nothing_specular, "vcm"), "") << "nothing is merged";
  EXPECT_EQ(told(wide, "bdpt"), "");
  // No photon tells where to guide them.
  SceneBuilder b("cellar");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
  b.light(PointLight{{0, 2, 0}, Rgb(1)});
  b.light(PointLight{{0, -2, 0}, Rgb(1e8f)});
  b.camera({0.3f, 1.5f, 3.5f}, {0, 0, 0}, 40, {16, 16});
  SceneContext stage(b.finish(), {16, 16}, 1);
  for (const char* emission : {"power", "visibility", "importance"})
    EXPECT_NE(light_out_of_reach(stage.context, "sppm", {{"emission", {std::string(emission), {}}}}), "") << emission;
}

TEST(LightOutOfReach, IsToldOfCausticsOfADistantLamp) {
  const auto told = [](const std::string& method, float distance, bool glass, const ParamMap& params = {}) {
    SceneBuilder b("a sun");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)});
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), grey);
    if (glass) b.quadric(Sphere{{0, 0.6f, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
    b.quadric(Sphere{{0, distance, 0}, 0.1f * distance}, grey, Rgb(100));
    b.camera({0.3f, 1.5f, 3.5f}, {0, 0, 0}, 40, {16, 16});
    SceneContext stage(b.finish(), {16, 16}, 1);
    return light_out_of_reach(stage.context, method, params);
  };
  for (const char* method : {"bdpt", "irradiance-cache", "hash-cache"}) {
    EXPECT_NE(told(method, 1e4f, true).find("no photon of a pilot lands"), std::string::npos) << method;
    EXPECT_EQ(told(method, 4, true), "") << method;
    EXPECT_EQ(told(method, 1e4f, false), "") << method;
  }
}

// Photons of the lit room next door, a few centimetres behind the wall, are no photons in view.
TEST(LightOutOfReach, IsToldOfRoomsLitThroughAKeyhole) {
  const auto told = [](const char* scene) {
    SceneContext stage(load_scene(scene), {64, 64}, 1);
    return light_out_of_reach(stage.context, "photon-map", {});
  };
  EXPECT_NE(told("builtin:keyhole?size=0.1").find("too few for light and shadow of what is small"), std::string::npos);
  EXPECT_EQ(told("builtin:keyhole"), "");
}

TEST(LeftOut, LightTraceTellsOfNarrowLobes) {
  const auto told = [](const Material& material) {
    SceneBuilder b("ball");
    b.quadric(Sphere{{0, 0, 0}, 1}, b.material(material));
    b.light(PointLight{{0, 3, 0}, Rgb(1)});
    b.camera({0, 0, 4}, {0, 0, 0}, 50, {8, 8});
    SceneContext stage(b.finish(), {8, 8}, 1);
    const auto integrator = find_integrator("light-trace", {}).make({});
    integrator->prepare(stage.context);
    return integrator->expectation().left_out;
  };
  EXPECT_NE(told(Dielectric{.eta = 1.001f, .alpha = 0.1f}).find("are noise or black"), std::string::npos);
  EXPECT_NE(told(Dielectric{.eta = 1.001f}).find("specular surfaces are black"), std::string::npos);
  EXPECT_EQ(told(Dielectric{.eta = 1.5f, .alpha = 0.1f}), "");
}

TEST(SurfacesMixed, AreToldWhereSheetsOfOneShapeThatLetLightThroughAreNear) {
  const auto told = [](float opacity, float height, bool one_shape, const char* method, const ParamMap& params = {}) {
    SceneBuilder b("sheets");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)});
    MeshData sheets = quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});
    MeshData upper = quad({-1, height, 1}, {1, height, 1}, {1, height, -1}, {-1, height, -1});
    if (one_shape) {
      for (const uvec3& t : upper.triangles) sheets.triangles.push_back(t + 4u);
      sheets.positions.insert(sheets.positions.end(), upper.positions.begin(), upper.positions.end());
      sheets.uvs.insert(sheets.uvs.end(), upper.uvs.begin(), upper.uvs.end());
    }
    b.mesh(std::move(sheets), grey);
    if (!one_shape) b.mesh(std::move(upper), grey);
    b.light(PointLight{{0, 2, 0}, Rgb(1)});
    b.camera({0, 2, 3.5f}, {0, 0.3f, 0}, 50, {16, 16});
    Scene scene = b.finish();
    scene.textures.push_back(ImageTexture{.size = {1, 1}, .texels = {Rgb(opacity)}});
    for (Shape& shape : scene.objects[0].shapes) shape.mask = 0;
    SceneContext stage(std::move(scene), {16, 16}, 1);
    std::string text;
    with_threads(2, [&] { text = surfaces_mixed(stage.context, method, params); });
    return text;
  };
  EXPECT_NE(told(0.5f, 0.001f, true, "vcm", {{"neighbours", {std::int64_t{1}, {}}}}), "");
  EXPECT_EQ(told(0.5f, 0.001f, true, "vcm"), "") << "nothing is merged";
  for (const char* method : {"photon-map", "sppm", "photon-cache"}) {
    EXPECT_NE(told(0.5f, 0.001f, true, method).find("path keeps them apart"), std::string::npos) << method;
    EXPECT_EQ(told(0.5f, 0.001f, false, method), "") << method;
  }
  for (const char* method : {"path", "irradiance-cache"}) EXPECT_EQ(told(0.5f, 0.001f, true, method), "") << method;
  EXPECT_NE(told(0.5f, 0.001f, true, "irradiance-cache", {{"caustic_map", {std::string("on"), {}}}}), "")
      << "kernels of its map";
  EXPECT_EQ(told(1, 0.001f, true, "sppm"), "");
  EXPECT_EQ(told(0.5f, 1, true, "sppm"), "");
}

TEST(SurfacesCoincide, AreToldWhereAPaneLiesInTheFloorItself) {
  const auto told = [](float height, const Material& pane) {
    SceneBuilder b("pane");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
    b.mesh(box({-0.9f, height, -0.8f}, {1, height + 0.1f, 0.7f}), b.material(pane));
    b.light(PointLight{{0, 2, 0}, Rgb(1)});
    b.camera({0.3f, 2, 3.5f}, {0, 0, 0}, 50, {16, 16});
    SceneContext stage(b.finish(), {16, 16}, 1);
    std::string text;
    with_threads(2, [&] { text = surfaces_coincide(stage.context); });
    return text;
  };
  EXPECT_NE(told(0, Dielectric{.eta = 1.5f}).find("of different materials in one place"), std::string::npos);
  EXPECT_EQ(told(1e-4f, Dielectric{.eta = 1.5f}), "");
  EXPECT_EQ(told(0, Diffuse{Rgb(0.2f)}), "") << "hidden by the box";
}

TEST(SurfacesCoincide, AreToldWhereGlassSharesSurfacesToTheLastBit) {
  // Each of the same materials in the world and in an instance: a floor, and a ball.
  const auto told = [](const Material& upper, float height, bool round, bool instanced) {
    SceneBuilder b("shared");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)}), other = b.material(upper);
    const auto add = [&](std::uint32_t material, float y) {
      if (round)
        b.quadric(Sphere{{0, 0.5f + y, 0}, 0.5f}, material);
      else
        b.mesh(quad({-2, y, 2}, {2, y, 2}, {2, y, -2}, {-2, y, -2}), material);
    };
    add(grey, 0);
    if (!instanced) add(other, height);
    b.light(PointLight{{0, 2, 0}, Rgb(1)});
    b.camera({0.3f, 2, 3.5f}, {0, 0, 0}, 50, {16, 16});
    Scene scene = b.finish();
    if (instanced) {
      Object object;
      object.geometry = scene.objects[0].geometry;
      object.shapes = scene.objects[0].shapes;
      object.shapes[0].material = other;
      scene.objects.push_back(object);
      scene.instances.push_back({1, Transform::translate({0, height, 0})});
    }
    SceneContext stage(std::move(scene), {16, 16}, 1);
    std::string text;
    with_threads(2, [&] { text = surfaces_coincide(stage.context); });
    return text;
  };
  const Dielectric glass{.eta = 1.5f};
  for (const bool round : {false, true})
    for (const bool instanced : {false, true}) {
      EXPECT_NE(told(glass, 0, round, instanced).find("of different materials in one place"), std::string::npos) << round;
      EXPECT_EQ(told(glass, 1e-3f, round, instanced), "") << round;
      EXPECT_EQ(told(Diffuse{Rgb(0.2f)}, 0, round, instanced), "") << "any of them is an image";
    }
}

TEST(LightsCoincide, AreToldWhereALampLiesInTheCeilingItself) {
  // A ceiling, and below it, by `gap`, a lamp of the same triangles or of others; and perhaps the lamp once more.
  const auto told = [](float gap, bool same, bool twice) {
    SceneBuilder b("ceiling");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)});
    const auto facing_down = [](float half, float y) {
      return quad({-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half});
    };
    b.mesh(facing_down(twice ? 3 : 2, twice ? 3 : 2), grey);
    for (int i = 0; i < (twice ? 2 : 1); ++i) b.mesh(facing_down(same ? 2 : 1.3f, 2 - gap), grey, Rgb(1));
    b.camera({0, 1, 4}, {0, 1, 0}, 50, {16, 16});
    SceneContext stage(b.finish(), {16, 16}, 1);
    std::string text;
    with_threads(2, [&] { text = lights_coincide(stage.context); });
    return text;
  };
  for (const bool same : {false, true}) {
    EXPECT_NE(told(0, same, false).find("of the light of lamps comes from where they lie in one place"), std::string::npos)
        << same;
    EXPECT_NE(told(0, same, true), "") << "the lamp is there twice";
    EXPECT_EQ(told(1e-3f, same, false), "") << same;
  }
}

TEST(LightsSeldomChosen, AreToldWhereAHiddenLightHasNearlyAllPower) {
  // A floor, a lamp above it, and another below, which is `times` as strong.
  const auto told = [](const std::string& method, float times, bool points, LightChoice choice = LightChoice::power) {
    SceneBuilder b("cellar");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)});
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), grey);
    if (points) {
      b.light(PointLight{{0, 2, 0}, Rgb(1)});
      b.light(PointLight{{0, -2, 0}, Rgb(times)});
    } else {
      b.mesh(quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}), grey, Rgb(1));
      b.mesh(quad({-1, -1, 1}, {1, -1, 1}, {1, -1, -1}, {-1, -1, -1}), grey, Rgb(times));
    }
    b.camera({0.3f, 1.5f, 3.5f}, {0, 0, 0}, 40, {16, 16});
    SceneContext stage(b.finish(), {16, 16}, 1);
    stage.context.choose_lights_by(choice);
    std::string text;
    with_threads(2, [&] { text = lights_seldom_chosen(stage.context, method); });
    return text;
  };
  for (const bool points : {false, true}) {
    EXPECT_NE(told("irradiance-cache", 1e6f, points).find("lights = \"uniform\" brings it"), std::string::npos);
    EXPECT_NE(told("sppm", 1e9f, points), "") << "below the steps of the numbers that choose";
    EXPECT_EQ(told("irradiance-cache", 100, points), "");
    EXPECT_EQ(told("irradiance-cache", 1e6f, points, LightChoice::uniform), "");
    EXPECT_EQ(told("light-trace", 1e6f, points), "") << "it takes no light samples";
  }
  EXPECT_NE(told("path", 1e6f, true), "");
  EXPECT_EQ(told("path", 1e6f, false), "") << "its other samples find the lamp";
}

// Pilots of other warnings choose lights in their own way.
TEST(LightsSeldomChosen, AreToldOfTheMethodsOwnChoice) {
  SceneBuilder b("cellar");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
  b.light(PointLight{{0, 2, 0}, Rgb(1)});
  b.light(PointLight{{0, -2, 0}, Rgb(1e6f)});
  b.camera({0.3f, 1.5f, 3.5f}, {0, 0, 0}, 40, {16, 16});
  const Scene scene = b.finish();
  const auto told = [&](const char* lights) {
    const Method accel{"binned-sah", {}, {}}, sppm{"sppm", {{"lights", {std::string(lights), {}}}}, {}};
    const Budget budget = Budget::of_iterations(2);
    const SceneNeeds needs = scene_needs(scene);
    CellTask task{scene, needs, accel, sppm, 1, {16, 16}, budget, 2};
    task.looks_for_left_out = true;
    return std::ranges::any_of(run_cell(task).out_of_reach,
                               [](const std::string& text) { return text.find("light sample in") != std::string::npos; });
  };
  EXPECT_TRUE(told("power"));
  EXPECT_FALSE(told("uniform"));
}

// What the method knows that it loses stands beside what a pilot finds, unless both say the same.
TEST(LeftOut, IsToldBesideLightOutOfReach) {
  const auto told = [](const std::string& name, const std::string& method) {
    const Scene scene = load_scene(name);
    const SceneNeeds needs = scene_needs(scene);
    const Method accel{"binned-sah", {}, {}}, used{method, {}, {}};
    const Budget budget = Budget::of_iterations(1);
    CellTask task{scene, needs, accel, used, 1, {16, 16}, budget, 2};
    task.looks_for_left_out = true;
    return run_cell(task).out_of_reach;
  };
  const auto says = [](const std::vector<std::string>& texts, std::string_view what) {
    return std::ranges::count_if(texts, [&](const std::string& text) { return text.find(what) != std::string::npos; });
  };
  const std::vector<std::string> both = told("builtin:sunlit-field?surroundings=64", "light-trace");
  EXPECT_EQ(says(both, "too few for light and shadow of what is small"), 1);
  EXPECT_EQ(says(both, "specular surfaces are black"), 1);
  EXPECT_EQ(says(told("builtin:mirror?view=mirror", "bdpt"), "specular"), 1);
}

}  // namespace
}  // namespace etendue::testing
