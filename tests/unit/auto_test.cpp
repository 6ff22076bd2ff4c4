// The method that chooses: what it chooses, that the choice repeats, and that the image is the chosen method's to the bit.
#include "experiments/config/method.h"
#include "framework/scene/builder.h"
#include "integrators/choice/choose.h"
#include "integrators/pilot/caustic_need.h"
#include "integrators/warnings/out_of_reach.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace etendue::testing {
namespace {

struct Choice {
  MethodChoice method;
  PilotFindings findings;
};

PilotFindings of_diffuse_surfaces() {
  PilotFindings findings;
  findings.surface = findings.diffuse = findings.path_error = 1;
  return findings;
}

Choice choice_in(const std::string& scene, const Effort& effort, int threads = 2, BiasAllowed bias = BiasAllowed::any) {
  Scene loaded = load_scene(scene);
  const ivec2 resolution = loaded.resolution;
  SceneContext stage(std::move(loaded), resolution, 1);
  stage.context.effort = effort;
  Choice choice;
  with_threads(threads, [&] {
    choice.findings = run_pilot_within_effort(stage.context);
    choice.method = choose_method(stage.context, choice.findings, bias);
  });
  return choice;
}

TEST(Pilot, FindsTheSameAtAnyNumberOfThreads) {
  for (const char* scene : {"builtin:glass-caustic", "builtin:two-rooms"}) {
    const PilotFindings one = choice_in(scene, {4}, 1).findings, three = choice_in(scene, {4}, 3).findings;
    for (const auto field :
         {&PilotFindings::path_error, &PilotFindings::direct_error, &PilotFindings::rays_per_path,
          &PilotFindings::caustic_light, &PilotFindings::unmet_caustics, &PilotFindings::caustic_hits,
          &PilotFindings::caustic_contrast, &PilotFindings::records, &PilotFindings::photons_seen, &PilotFindings::rays})
      EXPECT_EQ(one.*field, three.*field) << scene;
  }
}

TEST(Pilot, FindsTheSameWhateverPartOfTheImageIsWanted) {
  SceneContext stage(load_scene("builtin:cornell-box"), {256, 256}, 1);
  with_threads(2, [&] {
    const PilotFindings whole = run_pilot(stage.context);
    stage.context.window = {{200, 200}, {256, 256}};
    const PilotFindings part = run_pilot(stage.context);
    EXPECT_GT(part.path_error, 0);
    EXPECT_EQ(part.path_error, whole.path_error);
    EXPECT_EQ(part.rays, whole.rays);
  });
}

TEST(Pilot, TakesLessOfASmallBudget) {
  const auto rays_in = [](double seconds) { return choice_in("builtin:cornell-box", {seconds}).findings.rays; };
  const double whole = rays_in(4), small = rays_in(0.1);
  EXPECT_LT(small, 0.65 * whole);
  EXPECT_LT(small, 8e6 * 0.1 / 6);
  EXPECT_GT(rays_in(0.001), 0.4 * whole);  // of fewer it would not tell
}

TEST(Pilot, TellsScenesApart) {
  const PilotFindings direct = choice_in("builtin:polygon-light", {4}).findings;
  EXPECT_EQ(direct.direct_light, 1);
  EXPECT_EQ(direct.caustic_light, 0);
  EXPECT_NEAR(direct.direct_error / direct.path_error, 1, 0.3);
  const PilotFindings water = choice_in("builtin:water", {4}).findings;
  EXPECT_EQ(water.caustic_light, 1);
  EXPECT_EQ(water.path_error, 0);  // black: no path finds the light
  const PilotFindings box = choice_in("builtin:cornell-box", {4}).findings;
  EXPECT_GT(box.path_error, 2 * box.direct_error);
  EXPECT_GT(box.records, 100);
  EXPECT_LT(box.rays, 250'000);  // of 8 million in a second
}

// A plate of stone under a pane that reflects nothing, in the sun. From below its lower side and an edge are seen: dark ones.
TEST(Pilot, CountsCausticsOnTheSidesThatAreSeen) {
  const auto findings = [](float height) {
    SceneBuilder b("plate");
    const auto stone = b.material(Diffuse{Rgb(0.5f)});
    const auto level = [&](float y) { return quad({-1, y, 1}, {1, y, 1}, {1, y, -1}, {-1, y, -1}); };
    for (const float y : {0.0f, -0.01f}) b.mesh(level(y), stone);
    b.mesh(quad({-1, -0.01f, 1}, {1, -0.01f, 1}, {1, 0, 1}, {-1, 0, 1}), stone);
    b.mesh(level(1), b.material(Dielectric{.eta = 1}));
    b.light(DirectionalLight{.direction = {0, -1, 0}, .irradiance = Rgb(3)});
    b.camera({-0.9f, height, 2.4f}, {0, 0, 0}, 46, {32, 32});
    SceneContext stage(b.finish(), {32, 32}, 1);
    return run_pilot(stage.context);
  };
  EXPECT_EQ(findings(1.7f).caustic_light, 1);
  EXPECT_EQ(findings(-1.7f).caustic_light, 0);
  EXPECT_EQ(findings(-1.7f).unmet_caustics, 0);
}

TEST(AutoChoice, GoesByWhatTheSceneNeeds) {
  struct Chosen {
    double seconds;
    const char* method;
  };
  const std::pair<const char*, std::vector<Chosen>> expected[] = {
      {"builtin:polygon-light", {{4, "path"}}},                                       // nothing but direct light
      {"builtin:veach-mis", {{4, "irradiance-cache"}}},                               // and a little besides
      {"builtin:white-furnace", {{4, "path"}}},                                       // hardly a rough surface
      {"builtin:thin-plate", {{1, "path"}}},                                          // a caustic on the side that is not seen
      {"builtin:glossy-furnace", {{4, "path"}}},                                      // what lobes send on, not what lands
      {"builtin:furnace", {{4, "path"}}},                                             // no noise at all,
      {"builtin:concentric-spheres", {{4, "hash-cache"}, {16, "irradiance-cache"}}},  // little, of direct light,
      {"builtin:cavity", {{1, "photon-cache"}, {4, "photon-cache"}}},          // somewhat more, and photons are all in view,
      {"builtin:lambert-sphere-off-centre", {{4, "irradiance-cache"}}},        // and of indirect light
      {"builtin:water", {{4, "cppm"}}},                                        // all light through water, evenly
      {"builtin:edge", {{4, "sppm"}, {16, "bdpt"}}},                           // the same, up to a border in view
      {"builtin:glass-caustic", {{0.25, "cppm"}, {1, "cppm"}, {16, "cppm"}}},  // a sharp caustic
      {"builtin:thin-wall", {{4, "irradiance-cache"}, {16, "irradiance-cache"}}},  // mirrors that paths find the light in
      {"builtin:black-surroundings", {{0.1, "cppm"}, {4, "cppm"}}},                // and less easily,
      {"builtin:veiled-lamp", {{4, "cppm"}}},                                      // and too seldom
      {"builtin:two-rooms", {{1, "hash-cache"}, {4, "irradiance-cache"}}},         // light through a door
      {"builtin:mesh", {{1, "hash-cache"}, {4, "irradiance-cache"}}},              // too many records for a second,
      {"builtin:keyhole", {{0.25, "irradiance-cache"}}},                           // too few paths to share, either,
      {"builtin:cornell-box", {{1, "irradiance-cache"}}}};                         // records take time
  for (const auto& [name, choices] : expected) {
    Scene scene = load_scene(name);
    const ivec2 resolution = scene.resolution;
    SceneContext stage(std::move(scene), resolution, 1);
    with_threads(2, [&] {
      const PilotFindings findings = run_pilot(stage.context);
      for (const Chosen& chosen : choices) {
        stage.context.effort = {chosen.seconds};
        EXPECT_EQ(choose_method(stage.context, findings).name, chosen.method) << name << " in " << chosen.seconds;
      }
    });
  }
}

TEST(AutoChoice, KnowsEvenCausticsByManyPhotonsAlone) {
  PilotFindings findings;
  findings.surface = 0.5;
  findings.diffuse = findings.caustic_light = findings.unmet_caustics = 1;
  findings.caustic_contrast = 1;
  SceneContext stage(load_scene("builtin:water"), {64, 64}, 1);
  const auto chosen = [&](double photons, double seconds) {
    findings.caustic_photons = photons;
    stage.context.effort = {seconds};
    return choose_method(stage.context, findings).name;
  };
  EXPECT_EQ(chosen(20, 1), "cppm");
  EXPECT_EQ(chosen(1000, 1), "sppm");
  EXPECT_EQ(chosen(1000, 16), "bdpt");
  findings.path_error = 1;  // there is other light
  EXPECT_EQ(chosen(1000, 16), "sppm");
}

TEST(AutoChoice, LeavesNoiseOfDirectLightToPaths) {
  PilotFindings findings = of_diffuse_surfaces();
  findings.records = 100;
  findings.photons_seen = 0.5;
  SceneContext stage(load_scene("builtin:cornell-box"), {64, 64}, 1);
  const auto takes_paths = [&](double light, double error) {
    findings.direct_light = light;
    findings.direct_error = error;
    return choose_method(stage.context, findings).name == "path";
  };
  EXPECT_TRUE(takes_paths(0.85, 0.85));
  EXPECT_FALSE(takes_paths(0.85, 0.7));
  EXPECT_FALSE(takes_paths(0.4, 0.85));  // there is much to share
  findings.photons_seen = 0;             // so that nothing tells of shares
  EXPECT_TRUE(takes_paths(0, 0.85));
}

// Glass in the sun under a bright sky, which paths meet with far less noise than light samples do.
TEST(AutoChoice, BringsSunBehindGlassWithoutTheNoiseOfASampledSky) {
  PilotFindings findings = of_diffuse_surfaces();
  findings.caustic_light = 0.01;
  findings.unmet_caustics = 0.005;
  findings.caustic_hits = 0.1;
  findings.direct_error = 4;
  SceneContext stage(load_scene("builtin:glass-caustic"), {64, 64}, 1);
  EXPECT_EQ(choose_method(stage.context, findings).name, "bdpt");
  findings.direct_error = 1;
  EXPECT_EQ(choose_method(stage.context, findings).name, "cppm");
}

// A plate of polished metal throws light that paths hardly meet. Of what a less polished one throws light samples bring most.
TEST(AutoChoice, TakesPhotonsForCausticsOfRoughMetalsThatHardlyAnyPathMeets) {
  PilotFindings findings = of_diffuse_surfaces();
  findings.caustic_light = 0.03;
  findings.caustic_contrast = 2;
  findings.caustic_photons = 250;
  findings.direct_light = 0.85;
  findings.records = 100;
  const auto takes_photons = [&](const char* scene, double hits) {
    const SceneContext stage(load_scene(scene), {64, 64}, 1);
    findings.caustic_hits = hits * findings.caustic_light;
    return choose_method(stage.context, findings).name == "cppm";
  };
  EXPECT_TRUE(takes_photons("builtin:glossy-cornell-box", 0.006));
  EXPECT_FALSE(takes_photons("builtin:glossy-cornell-box", 0.02));
  EXPECT_TRUE(takes_photons("builtin:cornell-spheres", 0.02));  // of a mirror no light sample brings any
}

// The method for four seconds of a small image.
std::string chosen_for_a_box(const PilotFindings& findings, BiasAllowed bias = BiasAllowed::any) {
  SceneContext stage(load_scene("builtin:cornell-box"), {64, 64}, 1);
  stage.context.effort = {4};
  return choose_method(stage.context, findings, bias).name;
}

// A lamp that shines at the ceiling: nearly all light in view is indirect, and photons get there.
TEST(AutoChoice, TakesPhotonsForHiddenLightThatTheyBring) {
  PilotFindings findings = of_diffuse_surfaces();
  findings.direct_error = 0.04;
  findings.records = 100;
  findings.photons_seen = 2;
  EXPECT_EQ(chosen_for_a_box(findings), "sppm");
  findings.photons_seen = 0.3;  // behind a door
  EXPECT_NE(chosen_for_a_box(findings), "sppm");
  findings.photons_seen = 2;
  findings.direct_error = 0.2;
  EXPECT_NE(chosen_for_a_box(findings), "sppm");
}

// Where paths leave little noise, a map that all photons fill leaves less, unless bias has to vanish.
TEST(AutoChoice, TakesAMapWhereAllPhotonsAreInView) {
  PilotFindings findings = of_diffuse_surfaces();
  findings.diffuse = 0.9;
  findings.path_error = 0.15;
  findings.direct_error = 0.1;
  findings.records = 100;
  findings.photons_seen = 1.5;
  EXPECT_EQ(chosen_for_a_box(findings), "photon-cache");
  EXPECT_EQ(chosen_for_a_box(findings, BiasAllowed::vanishing), "hash-cache");
  findings.photons_seen = 0.9;
  EXPECT_EQ(chosen_for_a_box(findings), "hash-cache");
}

TEST(AutoChoice, LeavesNoCausticsOutThatNoPathFinds) {
  // Few photons of a pilot, or none, land in a small caustic.
  PilotFindings findings = of_diffuse_surfaces();
  findings.direct_error = 0.01;
  findings.records = 1000;
  const auto leaves_them_to_paths = [&](const std::optional<Light>& light) {
    Scene scene = load_scene("builtin:cornell-spheres");
    if (light) scene.lights.push_back(*light);
    const SceneContext stage(std::move(scene), {64, 64}, 1);
    EXPECT_EQ(choose_method(stage.context, findings).name, "hash-cache");
    return !caustics_need_photons(stage.context, findings, enough_hits_of_cells);
  };
  EXPECT_TRUE(leaves_them_to_paths(std::nullopt));
  EXPECT_FALSE(leaves_them_to_paths(PointLight{vec3(0), Rgb(1e-3f)}));
  // The photons tell of light that no path of the pilot meets, and that is less than the noise of all else.
  findings.caustic_light = 0.01;
  findings.caustic_contrast = 0.1;
  EXPECT_FALSE(leaves_them_to_paths(std::nullopt));
  findings.caustic_hits = 0.01;
  EXPECT_TRUE(leaves_them_to_paths(std::nullopt));
}

TEST(CausticNeed, IsThereWherePathsMeetTheLightTooSeldom) {
  const auto wanted = [](const char* name, double enough_hits) {
    SceneContext stage(load_scene(name), {64, 64}, 1);
    CausticParams params;
    decide_caustic_map(stage.context, params, enough_hits);
    return params.caustic_map == CausticMap::on;
  };
  for (const double enough : {enough_hits_of_records, enough_hits_of_cells}) {
    for (const char* scene : {"builtin:cornell-spheres", "builtin:glass-caustic", "builtin:slit-light", "builtin:veiled-lamp",
                              "builtin:water", "builtin:edge"})
      EXPECT_TRUE(wanted(scene, enough)) << scene;
    for (const char* scene : {"builtin:broad-light", "builtin:white-furnace", "builtin:glossy-furnace", "builtin:cornell-box"})
      EXPECT_FALSE(wanted(scene, enough)) << scene;
  }
  for (const char* scene : {"builtin:two-occluders", "builtin:thin-wall", "builtin:black-surroundings"}) {
    EXPECT_FALSE(wanted(scene, enough_hits_of_records)) << scene;
    EXPECT_TRUE(wanted(scene, enough_hits_of_cells)) << scene;
  }
}

TEST(AutoChoice, BringsTheSunBehindAWindowThroughWhichPathsFindTheSky) {
  PilotFindings findings;
  findings.surface = findings.diffuse = findings.path_error = findings.direct_error = findings.rays_per_path = 1;
  findings.records = 1000;
  findings.photons_seen = 0.5;
  findings.caustic_light = 0.8;
  findings.caustic_contrast = 2;
  findings.caustic_photons = 100;
  const SceneContext stage(load_scene("builtin:cornell-spheres"), {64, 64}, 1);
  for (const double hits : {0.1, 0.0}) {  // of the sky, or of a lamp in the room besides
    findings.caustic_hits = hits;
    findings.unmet_caustics = 0;
    EXPECT_NE(choose_method(stage.context, findings).name, "cppm") << hits;
    findings.unmet_caustics = 0.7;
    EXPECT_EQ(choose_method(stage.context, findings).name, "cppm") << hits;
  }
}

// A ball of glass on a floor under sun and sky: paths meet the sky in the ball often, and the sun never.
TEST(AutoChoice, LooksForTheCausticsOfASunBesideASky) {
  const auto scene = [](bool sun) {
    SceneBuilder b("sun and sky");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
    b.quadric(Sphere{{0, 0.6f, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
    if (sun) b.light(DirectionalLight{.direction = glm::normalize(vec3(0.3f, -1, 0.2f)), .irradiance = Rgb(3)});
    b.light(EnvironmentLight{.scale = Rgb(1), .size = ivec2(0), .texels = {}, .light_to_world = {}});
    b.camera({0, 2, 3.5f}, {0, 0.3f, 0}, 50, {64, 64});
    return b.finish();
  };
  SceneContext stage(scene(true), {64, 64}, 1), sky_alone(scene(false), {64, 64}, 1);
  stage.context.effort = sky_alone.context.effort = {4};
  with_threads(2, [&] {
    const PilotFindings findings = run_pilot(stage.context);
    EXPECT_GT(findings.unmet_caustics, 0.005);
    EXPECT_LT(findings.unmet_caustics, findings.caustic_light);
    EXPECT_GT(findings.caustic_hits, 0);
    EXPECT_NE(choose_method(stage.context, findings).name, "path");
    EXPECT_TRUE(caustics_need_photons(stage.context, findings, enough_hits_of_cells));
    EXPECT_NE(light_out_of_reach(stage.context, "path").find("path leaves it out"), std::string::npos);
    EXPECT_EQ(run_pilot(sky_alone.context).unmet_caustics, 0);
    EXPECT_EQ(light_out_of_reach(sky_alone.context, "path"), "");
  });
}

// Most light is that of a lamp in a ball of glass, a hundredth of its size, which no path of a pilot meets. Beside it they see
// a dim lamp, behind the ball too, or not there, or a sky, or a point.
TEST(AutoChoice, BringsALampBehindGlassBesideDimLight) {
  enum class Dim { above, aside, sky, point, none };
  const auto scene = [](Dim dim, const Material& floor) {
    SceneBuilder b("bulb");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(floor));
    const auto black = b.material(Diffuse{Rgb(0)});
    b.quadric(Sphere{{0, 1, 0}, 0.001f}, black, Rgb(1e6f));
    b.quadric(Sphere{{0, 1, 0}, 0.2f}, b.material(Dielectric{.eta = 1.5f}));
    if (dim == Dim::above) b.mesh(quad({-1, 3, -1}, {1, 3, -1}, {1, 3, 1}, {-1, 3, 1}), black, Rgb(0.2f));
    if (dim == Dim::aside) b.mesh(quad({-2, 0, -2}, {2, 0, -2}, {2, 0.1f, -2}, {-2, 0.1f, -2}), black, Rgb(1));
    if (dim == Dim::sky) b.light(EnvironmentLight{.scale = Rgb(0.1f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
    if (dim == Dim::point) b.light(PointLight{{0, 3, 1}, Rgb(0.1f)});
    b.camera({0, 2, 3.5f}, {0, 0.3f, 0}, 50, {64, 64});
    return b.finish();
  };
  const Plastic coated{.reflectance = Rgb(0.5f)}, glossy{.reflectance = Rgb(0.5f), .alpha = 0.3f};
  const std::array<std::pair<const char*, Material>, 3> floors{
      {{"diffuse", Diffuse{Rgb(0.5f)}}, {"coated", coated}, {"glossy", glossy}}};
  for (const auto& [name, floor] : floors)
    for (const Dim dim : {Dim::above, Dim::aside, Dim::sky, Dim::point, Dim::none}) {
      SCOPED_TRACE(fmt::format("{} floor, dim light {}", name, static_cast<int>(dim)));
      SceneContext stage(scene(dim, floor), {32, 32}, 1);
      stage.context.effort = {4};
      with_threads(2, [&] {
        const PilotFindings findings = run_pilot(stage.context);
        EXPECT_EQ(findings.path_error > 0, dim != Dim::none);
        // Lobes meet the sky in the ball; light paths bring the lamp all the same.
        const bool sky_in_ball = name == std::string("glossy") && dim == Dim::sky;
        EXPECT_EQ(choose_method(stage.context, findings).name, sky_in_ball ? "bdpt" : "cppm") << findings.caustic_hits;
        EXPECT_NE(light_out_of_reach(stage.context, "path").find("path leaves it"), std::string::npos);
        EXPECT_TRUE(caustics_need_photons(stage.context, findings, enough_hits_of_records));
      });
    }
}

// A room with a pane in a wide field in the sun: of the pilot's photons hardly any falls through it.
TEST(AutoChoice, BringsTheSunThroughAWindowThatPhotonsMiss) {
  SceneBuilder b("window");
  const auto grey = b.material(Diffuse{Rgb(0.6f)});
  b.mesh(quad({-300, -0.01f, 300}, {300, -0.01f, 300}, {300, -0.01f, -300}, {-300, -0.01f, -300}), grey);
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), grey);
  for (const float y : {3.0f, 2.9f}) b.mesh(quad({-2, y, -1}, {2, y, -1}, {2, y, 2}, {-2, y, 2}), grey);
  b.mesh(quad({-2, 3, -2}, {2, 3, -2}, {2, 3, -1}, {-2, 3, -1}), b.material(Dielectric{.eta = 1.5f}));
  b.light(DirectionalLight{.direction = glm::normalize(vec3(0.1f, -1, 0.2f)), .irradiance = Rgb(3)});
  b.light(PointLight{{0, 2, 1}, Rgb(0.1f)});
  b.camera({0, 2, 1.5f}, {0, 0, -0.5f}, 50, {32, 32});
  SceneContext stage(b.finish(), {32, 32}, 1);
  stage.context.effort = {4};
  with_threads(2, [&] {
    EXPECT_EQ(choose_method(stage.context, run_pilot(stage.context)).name, "cppm");
    EXPECT_NE(light_out_of_reach(stage.context, "path").find("path leaves it out"), std::string::npos);
  });
}

TEST(AutoChoice, IsUnbiasedWhereThatIsAskedFor) {
  for (const char* scene : {"builtin:cornell-box", "builtin:glass-caustic", "builtin:water", "builtin:two-rooms"})
    for (const double seconds : {1.0, 16.0}) {
      const MethodChoice any = choice_in(scene, {seconds}).method;
      EXPECT_FALSE(any.why.empty());
      const auto expected = [&](BiasAllowed bias) {
        const MethodChoice choice = choice_in(scene, {seconds}, 2, bias).method;
        return find_integrator(choice.name, {}).make(choice.params)->expectation().bias;
      };
      EXPECT_NE(expected(BiasAllowed::vanishing), Bias::biased) << scene;
      EXPECT_EQ(expected(BiasAllowed::none), Bias::unbiased) << scene;
    }
}

// Nothing but the sun through a pane, even over all that is seen: in time a map and records leave less noise than kernels.
TEST(AutoChoice, StoresCausticsThatAreEvenAndAlone) {
  const auto chosen = [](const char* scene, double seconds, BiasAllowed bias) {
    SceneContext stage(load_scene(scene), {96, 96}, 1);
    stage.context.effort = {seconds};
    return choose_method(stage.context, run_pilot_within_effort(stage.context), bias).name;
  };
  EXPECT_EQ(chosen("builtin:sunlit-field", 0.25, BiasAllowed::any), "photon-cache");
  EXPECT_EQ(chosen("builtin:sunlit-field", 0.05, BiasAllowed::any), "cppm");
  EXPECT_EQ(chosen("builtin:sunlit-field", 4, BiasAllowed::vanishing), "cppm");
  EXPECT_EQ(chosen("builtin:mirror", 1, BiasAllowed::any), "photon-cache");  // beside even direct light
  EXPECT_EQ(chosen("builtin:mirror", 0.25, BiasAllowed::any), "cppm");
}

class AutoRender : public ProgramTest {};

TEST_F(AutoRender, TakesTheStructureThatTheBudgetPaysFor) {
  const auto render = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"render", "builtin:mesh", "--resolution", "16x16", "--spp", "4", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto structure = [&](const std::vector<std::string>& more) { return render(more)["chosen_accel"]["accel"]; };
  const auto chosen = render({"--accel", "auto"});
  EXPECT_EQ(chosen["chosen_accel"]["accel"], "lbvh layout=auto");
  EXPECT_EQ(chosen["image_hash"], render({"--accel", "binned-sah"})["image_hash"]);
  // So does the method `auto`, for the time that it was told to choose for, unless a structure or its parameters are named.
  EXPECT_EQ(structure({"-i", "auto"}), "lbvh layout=auto");
  EXPECT_EQ(structure({"-i", "auto", "-p", "seconds=1000"}), "sah layout=auto reinsertion=9");
  EXPECT_EQ(structure({"-i", "auto", "--accel", "sah"}), nullptr);
  EXPECT_EQ(structure({"-i", "auto", "-p", "accel.layout=bvh8"}), nullptr);
}

TEST_F(AutoRender, IsAdvisedByInspect) {
  const Outcome outcome = run({"inspect", "builtin:water", "--pilot", "--time", "4s", "--json", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto advice = nlohmann::json::parse(outcome.out)["advice"];
  EXPECT_EQ(advice["method"], "cppm");
  EXPECT_EQ(advice["pilot"]["caustic_light"], 1);
  EXPECT_GT(advice["expected"][0]["time_s"], 0);
  EXPECT_GT(advice["memory_bytes"], 0);
  ASSERT_FALSE(advice["hazards"].empty());
  EXPECT_NE(advice["hazards"][0].get<std::string>().find("path leaves it out"), std::string::npos);
  EXPECT_EQ(run({"inspect", "builtin:water", "--time", "4s"}).status, 2);
}

// One of a thousand lamps lights what is seen: pixels that have met it are as bright as the others are dark, and one iteration
// has a relMSE of some 400.
TEST_F(AutoRender, AdviceKnowsTheNoiseOfWhatFewPixelsHaveMet) {
  const Outcome outcome =
      run({"inspect", "builtin:many-lamps?lamps=1000", "--pilot", "--time", "0.2s", "--json", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto trial = nlohmann::json::parse(outcome.out)["advice"]["trial"];
  EXPECT_GT(trial["relmse"].get<double>() * trial["iterations"].get<double>(), 100);
}

TEST_F(AutoRender, IsTheChosenMethodToTheBitAtAnyNumberOfThreads) {
  const std::vector<std::string> shared{"render", "builtin:cornell-spheres", "--resolution", "24x24", "--spp", "3", "--json"};
  const auto render = [&](std::vector<std::string> more) {
    more.insert(more.begin(), shared.begin(), shared.end());
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto one = render({"-i", "auto", "--threads", "1", "-o", "auto.exr"});
  const auto three = render({"-i", "auto", "--threads", "3"});
  EXPECT_EQ(one["image_hash"], three["image_hash"]);
  EXPECT_EQ(one["chosen"], three["chosen"]);
  EXPECT_FALSE(one["chosen"]["why"].get<std::string>().empty());
  const std::vector<std::string> words = words_of(one["chosen"]["integrator"].get<std::string>());
  std::vector<std::string> itself{"-i", words.front()};
  for (std::size_t i = 1; i < words.size(); ++i) itself.insert(itself.end(), {"-p", words[i]});
  EXPECT_EQ(render(itself)["image_hash"], one["image_hash"]);
  const Outcome again = run({"render", "--from", "auto.exr", "-o", "again.exr"});
  EXPECT_EQ(again.status, 0) << again.err;
}

}  // namespace
}  // namespace etendue::testing
