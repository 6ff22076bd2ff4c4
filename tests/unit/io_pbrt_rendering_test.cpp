// Integrator, Sampler, PixelFilter and Accelerator: pbrt's names and parameters are known, all others refused.
#include "tests/unit/io_pbrt_helpers.h"

namespace etendue {
namespace {

Scene with(const std::string& directives) {
  return parse_pbrt("Camera \"perspective\"\n" + directives + "\nWorldBegin\nLightSource \"point\"\n" + triangle, "s.pbrt");
}

const std::string of_some_depth = "Integrator \"path\" \"integer maxdepth\" 7 ";  // of which nothing is warned

TEST(PbrtRendering, MisspeltNamesAreErrors) {
  EXPECT_ERROR(with("Integrator \"patth\" \"integer maxdepth\" 1"),
               "s.pbrt:2:12: unknown integrator 'patth'; did you mean 'path'");
  EXPECT_ERROR(with("Sampler \"haltton\""), "s.pbrt:2:9: unknown sampler 'haltton'; did you mean 'halton'");
  EXPECT_ERROR(with("PixelFilter \"gausian\""), "s.pbrt:2:13: unknown pixel filter 'gausian'; did you mean 'gaussian'");
  EXPECT_ERROR(with("Accelerator \"bhv\""), "s.pbrt:2:13: unknown accelerator 'bhv'; did you mean 'bvh'");
  EXPECT_ERROR(with("ColorSpace \"srgbb\""), "s.pbrt:2:12: unknown colour space 'srgbb'; did you mean 'srgb'");
  EXPECT_ERROR(with("Film \"rgbb\""), "s.pbrt:2:6: unknown film 'rgbb'; did you mean 'rgb'");
}

TEST(PbrtRendering, MisspeltParametersAreErrors) {
  const std::string known = "; did you mean 'maxdepth'?";
  for (const char* name : {"path", "volpath", "bdpt", "sppm", "mlt", "directlighting", "whitted", "randomwalk", "simplepath"})
    EXPECT_ERROR(with(std::string("Integrator \"") + name + "\" \"integer maxxdepth\" 1"),
                 std::string("s.pbrt:2:") + std::to_string(15 + std::string_view(name).size()) + ": Integrator \"" + name +
                     "\": unknown parameter 'maxxdepth'" + known);
  EXPECT_ERROR(with("Sampler \"halton\" \"integer foo\" 4"), "s.pbrt:2:18: Sampler \"halton\": unknown parameter 'foo'");
  EXPECT_ERROR(with("Sampler \"zsobol\" \"integer pixelsample\" 4"), "did you mean 'pixelsamples'");
  EXPECT_ERROR(with("PixelFilter \"box\" \"float xradiuss\" 1"), "did you mean 'xradius'");
  EXPECT_ERROR(with("PixelFilter \"gaussian\" \"float B\" 1"), "unknown parameter 'B'");
  EXPECT_ERROR(with("Accelerator \"bvh\" \"integer maxnodeprim\" 1"), "did you mean 'maxnodeprims'");
  EXPECT_ERROR(with("Film \"rgb\" \"integer xresolutio\" 1"), "did you mean 'xresolution'");
  EXPECT_ERROR(with("Option \"integer sed\" 1"), "did you mean 'seed'");
  EXPECT_ERROR(parse_pbrt("Camera \"perspective\" \"float fovv\" 1\nWorldBegin\n", "s.pbrt"), "did you mean 'fov'");
}

TEST(PbrtRendering, ParametersHaveTheirTypes) {
  EXPECT_ERROR(with("Integrator \"path\" \"float maxdepth\" 1"), "'maxdepth' is of type float; expected integer");
  EXPECT_ERROR(with("Sampler \"halton\" \"string pixelsamples\" \"4\""), "'pixelsamples' is of type string; expected integer");
  EXPECT_ERROR(with("PixelFilter \"box\" \"bool xradius\" true"), "'xradius' is of type bool; expected float");
  EXPECT_ERROR(with("Integrator \"path\" \"integer maxdepth\" [1 2]"), "'maxdepth' has 2 values; expected one");
}

TEST(PbrtRendering, PbrtsOwnAreAccepted) {
  for (const char* accepted :
       {"Integrator \"path\" \"integer maxdepth\" 7 \"string lightsampler\" \"power\" \"bool regularize\" false",
        "Integrator \"path\" \"integer maxdepth\" 7 \"float rrthreshold\" 1 \"string lightsamplestrategy\" \"spatial\"",
        "Integrator \"bdpt\" \"integer maxdepth\" 7 \"bool visualizestrategies\" false",
        "Integrator \"simplepath\" \"integer maxdepth\" 7 \"bool samplebsdf\" true",
        "Integrator \"sppm\" \"integer maxdepth\" 7 \"integer photonsperiteration\" -1 \"float radius\" 0.1 \"integer "
        "numiterations\" 64",
        "Integrator \"mlt\" \"integer maxdepth\" 7 \"integer chains\" 1000 \"float sigma\" 0.01",
        "Sampler \"halton\" \"integer pixelsamples\" 4 \"string randomization\" \"owen\" \"integer seed\" 3",
        "Sampler \"stratified\" \"bool jitter\" true \"integer xsamples\" 4 \"integer ysamples\" 4",
        "Sampler \"02sequence\" \"integer pixelsamples\" 4 \"integer dimensions\" 2", "Sampler \"independent\"",
        "Accelerator \"bvh\" \"string splitmethod\" \"sah\"", "Accelerator \"kdtree\" \"float emptybonus\" 0.5",
        "PixelFilter \"box\" \"float xradius\" 0.5", "Option \"bool disablepixeljitter\" false"}) {
    Scene scene;
    ASSERT_EQ(error_of([&] { scene = with(of_some_depth + accepted); }), "") << accepted;
    EXPECT_TRUE(scene.warnings.empty()) << accepted << ": " << scene.warnings.front();
  }
  EXPECT_EQ(with("Integrator \"path\" \"integer maxdepth\" 7").max_depth, 7);
  const std::string unsaid = "without 'maxdepth' pbrt ends paths after 5";
  EXPECT_TRUE(warns(with("Integrator \"volpath\""), unsaid));
  EXPECT_TRUE(warns(with(""), "s.pbrt: without an Integrator pbrt ends paths after 5"));
  EXPECT_FALSE(warns(with("Integrator \"volpath\""), "without an Integrator"));
  EXPECT_FALSE(warns(with("Integrator \"volpath\" Integrator \"path\" \"integer maxdepth\" 7"), unsaid));
}

TEST(PbrtRendering, OptionsHaveANameAndAValue) {
  for (const char* accepted :
       {"Option \"disablepixeljitter\" false", "Option \"disable-texture-filtering\" true", "Option \"seed\" 3",
        "Option \"mseReferenceImage\" \"a.exr\"", "Option \"displacementedgescale\" 0.5", "Option \"forcediffuse\" false"}) {
    Scene scene;
    ASSERT_EQ(error_of([&] { scene = with(of_some_depth + accepted); }), "") << accepted;
    EXPECT_TRUE(scene.warnings.empty()) << accepted << ": " << scene.warnings.front();
  }
  EXPECT_TRUE(warns(with("Option \"disablepixeljitter\" true"), "s.pbrt:2:8: Option: 'disablepixeljitter' has no effect"));
  EXPECT_ERROR(with("Option \"sed\" 1"), "s.pbrt:2:8: unknown option 'sed'; did you mean 'seed'");
  EXPECT_ERROR(with("Option \"wavefront\" 1"), "s.pbrt:2:20: Option 'wavefront': expected true or false, found '1'");
  EXPECT_ERROR(with("Option \"seed\" ["), "Option 'seed': expected a value");
  EXPECT_ERROR(with("Option \"forcediffuse\" true"), "'forcediffuse' is not supported");
}

TEST(PbrtRendering, WhatWouldChangeTheImageIsTold) {
  EXPECT_TRUE(
      warns(with("Integrator \"volpath\" \"bool regularize\" true"), "s.pbrt:2:22: Integrator: 'regularize' has no effect"));
  EXPECT_TRUE(warns(with("Integrator \"path\" \"integer pixelbounds\" [0 1 0 1]"), "'pixelbounds' has no effect"));
  EXPECT_TRUE(warns(with("Integrator \"ao\""), "s.pbrt:2:12: Integrator \"ao\" shows a part of the light in pbrt"));
}

TEST(PbrtRendering, OfSeveralIntegratorsAndFilmsTheLastCounts) {
  const Scene scene = parse_pbrt(
      "Integrator \"path\" \"integer maxdepth\" 3 Film \"rgb\" \"float cropwindow\" [0 .5 0 .5]\n"
      "Integrator \"bdpt\" Film \"rgb\" \"integer xresolution\" 8 WorldBegin",
      "s.pbrt");
  EXPECT_FALSE(scene.max_depth.has_value());
  EXPECT_FALSE(scene.crop.has_value());
  EXPECT_EQ(scene.resolution, ivec2(8, 720));
}

TEST(PbrtRendering, FiltersAreThoseOfTheFilesVersion) {
  const auto filter = [](const std::string& text) { return with(text).filter->shape(); };
  EXPECT_EQ(with("PixelFilter \"box\"").filter, nullptr);
  EXPECT_EQ(with("Film \"image\"").filter, nullptr);
  for (const char* film : {"Film \"rgb\"", "Film \"gbuffer\"", "Film \"spectral\"", ""})
    EXPECT_EQ(filter(film), (FilterShape{.kind = FilterKind::gaussian, .radius = vec2(1.5f), .sigma = 0.5f}))
        << "by default in version 4";
  EXPECT_EQ(with("PixelFilter \"box\" Film \"rgb\"").filter, nullptr);
  EXPECT_EQ(with("").resolution, ivec2(1280, 720));
  EXPECT_EQ(parse_pbrt("WorldBegin\n" + triangle + "WorldEnd\n", "s.pbrt").filter, nullptr) << "of version 3, without a film";
  EXPECT_TRUE(parse_pbrt("WorldBegin # WorldEnd\n" + triangle, "s.pbrt").filter);
  EXPECT_TRUE(parse_pbrt("Film \"rgb\"\nWorldBegin # WorldEnd\n" + triangle, "s.pbrt").filter);
  EXPECT_EQ(filter("PixelFilter \"box\" \"float xwidth\" 1 \"float ywidth\" 2"), (FilterShape{.radius = {1, 2}}));
  EXPECT_EQ(filter("PixelFilter \"mitchell\" \"float B\" 0.25"),
            (FilterShape{.kind = FilterKind::mitchell, .radius = vec2(2), .b = 0.25f}));
  EXPECT_EQ(filter("PixelFilter \"gaussian\"").radius, vec2(1.5f));
  EXPECT_EQ(filter("PixelFilter \"gaussian\" Film \"image\"").radius, vec2(2)) << "of version 3";
  EXPECT_EQ(filter("PixelFilter \"gaussian\" \"float xwidth\" 3 Film \"image\"").radius, vec2(3, 2));
  EXPECT_FLOAT_EQ(filter("PixelFilter \"gaussian\" \"float alpha\" 8").sigma, 0.25f);
  EXPECT_EQ(filter("PixelFilter \"sinc\" \"float tau\" 2").tau, 2);
  EXPECT_ERROR(with("PixelFilter \"triangle\" \"float xradius\" 0"), "'xradius' is 0; expected 0.01 to 32");
}

TEST(PbrtRendering, OpenShuttersLightTheImageOfVersion4) {
  const auto intensity = [](const std::string& film, const std::string& shutter) {
    const Scene scene =
        parse_pbrt(film + "\nCamera \"perspective\" " + shutter + " WorldBegin LightSource \"point\" " + triangle, "s.pbrt");
    EXPECT_TRUE(warns(scene, "nothing moves"));
    return std::get<PointLight>(scene.lights.at(0)).intensity.x;
  };
  EXPECT_FLOAT_EQ(intensity("", "\"float shutteropen\" 0.5 \"float shutterclose\" 0.75"), 0.25f);
  EXPECT_FLOAT_EQ(intensity("", "\"float shutterclose\" 2"), 2);
  EXPECT_FLOAT_EQ(intensity("Film \"image\"", "\"float shutterclose\" 2"), 1);
  EXPECT_ERROR(intensity("", "\"float shutteropen\" 1"), "s.pbrt:2:1: Camera: 'shutterclose' is not after 'shutteropen'");
}

TEST(PbrtRendering, ScaledCamerasAreOfTheWorldsScale) {
  const auto camera = [](const std::string& scale) {
    return parse_pbrt(
               scale +
                   " LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" 4 "
                   "WorldBegin " +
                   triangle,
               "s.pbrt")
        .camera;
  };
  const Camera doubled = camera("Scale 2 2 2");
  EXPECT_NEAR(*doubled.to_world.similarity_scale(), 1, 1e-6f);
  EXPECT_NEAR(doubled.lens_radius, 0.05f, 1e-6f);
  EXPECT_NEAR(doubled.focal_distance, 2, 1e-6f);
  EXPECT_FALSE(doubled.distorts);
  EXPECT_TRUE(camera("Scale 1 2 1").distorts);
}

TEST(PbrtRendering, DirectLightIsScatteredOnceWhereNothingIsSpecular) {
  for (const std::string name : {"whitted", "directlighting"}) {
    const std::string integrator = "Integrator \"" + name + "\" \"integer maxdepth\" 5";
    EXPECT_EQ(with(integrator).max_depth, 1);
    EXPECT_TRUE(with(integrator).warnings.empty());
    const Scene mirror = parse_pbrt(integrator + " WorldBegin LightSource \"point\" Material \"mirror\" " + triangle, "s.pbrt");
    EXPECT_EQ(mirror.max_depth, 5);
    EXPECT_TRUE(warns(mirror, "shows a part of the light in pbrt"));
  }
  EXPECT_EQ(with("Integrator \"whitted\"\nIntegrator \"path\" \"integer maxdepth\" 9").max_depth, 9);
}

}  // namespace
}  // namespace etendue
