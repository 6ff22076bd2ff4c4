// Lights and spectra.
#include "framework/core/elementary.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/spectra.h"
#include "framework/transport/light_sampling.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <fmt/format.h>

namespace etendue {
namespace {

TEST(PbrtLights, NegativeTexelsAreClamped) {
  const TestDirectory directory;
  Image image({2, 1});
  image.pixels = {{1, 2, -3}, {std::numeric_limits<double>::infinity(), 1, 1}};
  write_exr(directory.path("sky.exr"), image);
  const Scene scene =
      parse_pbrt("WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.exr\" " + triangle, directory.path("s.pbrt"));
  EXPECT_EQ(std::get<EnvironmentLight>(scene.lights.at(0)).texels, (std::vector<Rgb>{{1, 2, 0}, {0, 1, 1}}));
  EXPECT_TRUE(warns(scene, "'sky.exr' falls to -3"));
  EXPECT_TRUE(warns(scene, "'sky.exr' holds NaN or infinity in 1 texels"));
}

TEST(PbrtLights, ImagesOfVersion3AreNotDecoded) {
  const TestDirectory directory;
  const std::uint8_t grey[3] = {51, 51, 51};
  const auto png = encode_png(grey, {1, 1});
  directory.write("sky.png", std::string(png.begin(), png.end()));
  const auto texel = [&](const std::string& film) {
    const std::string sky = " WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.png\" ";
    return std::get<EnvironmentLight>(parse_pbrt(film + sky + triangle, directory.path("s.pbrt")).lights.at(0)).texels.at(0);
  };
  expect_near(texel("Film \"image\""), Rgb(0.2f));
  expect_near(texel("Film \"rgb\""), Rgb(0.0331f), 1e-4f);
}

TEST(PbrtLights, DeltaLights) {
  const PointLight point =
      light_of<PointLight>("Translate 1 0 0 LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2 \"point3 from\" [0 1 0]");
  expect_near(point.position, {1, 1, 0});
  expect_near(point.intensity, {2, 4, 6});
  const SpotLight spot = light_of<SpotLight>(
      "LightSource \"spot\" \"point3 from\" [0 0 2] \"point3 to\" [0 0 0] \"float coneangle\" 60 \"float conedeltaangle\" 15");
  expect_near(spot.direction, {0, 0, -1});
  EXPECT_NEAR(spot.cos_outer, 0.5f, 1e-6);
  EXPECT_NEAR(spot.cos_inner, std::sqrt(0.5f), 1e-6);
  EXPECT_EQ(spot.fade, SpotFade::cubic);
  const Scene version3 = parse_pbrt("Film \"image\" WorldBegin LightSource \"spot\" " + triangle, "s.pbrt");
  const auto& old = std::get<SpotLight>(version3.lights.at(0));
  const float middle = math::acos(0.5f * (old.cos_inner + old.cos_outer));
  EXPECT_NEAR(spot_falloff(old, {math::sin(middle), 0, math::cos(middle)}), 1.0f / 16, 1e-3f);
  const std::string scaled = "WorldBegin Translate 1 0 0 Scale 2 2 2 LightSource \"point\" \"point from\" [0 1 0] " + triangle;
  const auto position = [](const Scene& scene) { return std::get<PointLight>(scene.lights.at(0)).position; };
  expect_near(position(parse_pbrt("Film \"rgb\" " + scaled, "s.pbrt")), {1, 2, 0});
  expect_near(position(parse_pbrt("Film \"image\" " + scaled, "s.pbrt")), {1, 1, 0});
  // pbrt's distant light shines from 'from' towards 'to'.
  const DirectionalLight distant = light_of<DirectionalLight>(
      "Rotate 90 1 0 0 LightSource \"distant\" \"point3 from\" [0 0 0] \"point3 to\" [0 0 5] \"rgb L\" [3 3 3]");
  expect_near(distant.direction, {0, -1, 0});
  expect_near(distant.irradiance, Rgb(3));
  // Version 4 states the power of a light of colour 1, over all directions or within the cone.
  expect_near(light_of<PointLight>("LightSource \"point\" \"float power\" 100 \"rgb I\" [1 .5 1]").intensity,
              {100 / (4 * pi), 50 / (4 * pi), 100 / (4 * pi)}, 1e-4f);
  expect_near(
      light_of<SpotLight>("LightSource \"spot\" \"float power\" 3 \"float coneangle\" 90 \"float conedelta\" 0").intensity,
      Rgb(3 / (2 * pi)), 1e-4f);
  expect_near(light_of<DirectionalLight>("LightSource \"distant\" \"float illuminance\" 5").irradiance, Rgb(5));
  EXPECT_ERROR(light_of<DirectionalLight>("LightSource \"distant\" \"float power\" 100"), "'power' is not supported");
  EXPECT_ERROR(light_of<SpotLight>("LightSource \"spot\" \"float coneangle\" 10 \"float conedeltaangle\" 20"),
               "no more than coneangle");
  EXPECT_ERROR(light_of<SpotLight>("Scale 2 1 1 LightSource \"spot\""), "its transform distorts the cone");
  EXPECT_ERROR(light_of<SpotLight>("LightSource \"spot\" \"float coneangle\" 0.1"), "expected 0.3");
  EXPECT_ERROR(light_of<DirectionalLight>("LightSource \"distant\" \"point3 to\" [0 0 0]"), "has no direction");
  EXPECT_ERROR(light_of<PointLight>("LightSource \"point\" \"rgb I\" [-1 0 0]"), "has the component -1");
  EXPECT_TRUE(warns(world("LightSource \"point\" \"rgb I\" [0 0 0]"), "is black"));
}

// A stated power is that of all that the light emits, however dark its image.
TEST(PbrtLights, PowerOfLightsWithImagesIsThatOfTheWholeLight) {
  const TestDirectory directory;
  const auto image = [&](const std::string& size, const std::vector<float>& texel, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes.append(reinterpret_cast<const char*>(texel.data()), texel.size() * sizeof(float));
    directory.write("a.pfm", "PF\n" + size + "\n-1.0\n" + bytes);
  };
  const auto light = [&](const std::string& film, const std::string& text) {
    return parse_pbrt(film + " WorldBegin LightSource " + text + " " + triangle, directory.path("s.pbrt"),
                      {.approximate = true})
        .lights.at(0);
  };
  const auto intensity = [&](const std::string& film, const std::string& params) {
    return std::get<PointLight>(light(film, "\"goniometric\" " + params)).intensity;
  };
  const std::string file = "\"string filename\" \"a.pfm\" ", power = "\"float power\" 100 ";
  image("2 2", {0.1f, 0.1f, 0.1f}, 4);
  expect_near(intensity("", file + power), Rgb(100 / (4 * pi)), 1e-3f);
  expect_near(intensity("", file), Rgb(0.1f));
  image("2 2", {0.3f, 0.6f, 0}, 4);
  expect_near(intensity("", file), Rgb(0.3f));
  expect_near(intensity("Film \"image\"", "\"string mapname\" \"a.pfm\""), {0.3f, 0.6f, 0});
  image("2 1", {0.2f, 0.2f, 0.2f}, 2);
  const auto wide = std::get<SpotLight>(light("", "\"projection\" " + file + "\"float power\" 3"));
  const float solid_angle = 4 * std::asin(2 / std::sqrt(10.0f));  // of a rectangle of half sides 2 and 1 at distance 1
  expect_near(wide.intensity, Rgb(3 / solid_angle), 1e-3f);
  EXPECT_NEAR(wide.cos_inner, 1 - solid_angle / (2 * pi), 1e-4f);
}

TEST(PbrtLights, ProjectionsSpanTheirVersionsAngle) {
  const auto cosine = [](const std::string& film) {
    const Scene scene =
        parse_pbrt(film + " WorldBegin LightSource \"projection\" " + triangle, "s.pbrt", {.approximate = true});
    return std::get<SpotLight>(scene.lights.at(0)).cos_inner;
  };
  EXPECT_NEAR(cosine("Film \"rgb\""), 2.0f / 3, 1e-4f) << "90 degrees: a face of a cube";
  EXPECT_NEAR(cosine("Film \"image\""), 1 - 2 / pi * std::asin(0.1464466f), 1e-4f) << "45 degrees";
}

TEST(PbrtLights, NarrowSpotsHaveTheFadingOfFiveDegrees) {
  const auto spot = [](const std::string& film, const std::string& angle) {
    return parse_pbrt(film + " WorldBegin LightSource \"spot\" \"float coneangle\" " + angle + " " + triangle, "s.pbrt");
  };
  const auto falloff = [&](const std::string& film, const char* angle, float degrees) {
    const float theta = degrees * pi / 180;
    return spot_falloff(std::get<SpotLight>(spot(film, angle).lights.at(0)), {math::sin(theta), 0, math::cos(theta)});
  };
  for (const char* film : {"Film \"image\"", "Film \"rgb\""}) {
    EXPECT_EQ(falloff(film, "4", 0.9f), 1) << "cos(4 - 5 degrees) is where light begins to fade";
    EXPECT_LT(falloff(film, "4", 1.1f), 1);
    EXPECT_EQ(falloff(film, "2", 1.9f), 1) << "five degrees are more than twice the cone: its edge is hard";
    EXPECT_EQ(falloff(film, "2", 2.1f), 0);
  }
  EXPECT_TRUE(warns(spot("Film \"rgb\"", "2"), "pbrt-v4 fades over"));
  EXPECT_FALSE(warns(spot("Film \"rgb\"", "4"), "fades"));
  EXPECT_FALSE(warns(spot("Film \"image\"", "2"), "fades"));
}

TEST(PbrtLights, PowerIsThatOfTheWholeShapeWhateverAlphaCutsAway) {
  const auto radiance = [](const std::string& alpha) {
    const Scene scene = approximated(
        "Texture \"a\" \"float\" \"checkerboard\" \"float tex1\" 1 \"float tex2\" 0 AreaLightSource \"diffuse\" \"float "
        "power\" 8 "
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"point2 uv\" [0 0 2 0 2 2 0 2] \"integer indices\" "
        "[0 1 2 0 2 3] " +
        alpha);
    return std::get<AreaLight>(scene.lights.at(0)).radiance.x;
  };
  EXPECT_FLOAT_EQ(radiance("\"texture alpha\" \"a\""), radiance("")) << "two triangles of 8 each over all of the square";
  EXPECT_NEAR(radiance(""), 16 / pi, 1e-4f);
}

TEST(PbrtLights, AreaLightsCoverTheirShapes) {
  const Scene scene =
      world("AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool twosided\" \"true\"\n" +
            triangle + "Shape \"sphere\" AttributeEnd\n" + triangle + "LightSource \"point\"");
  ASSERT_EQ(scene.lights.size(), 3u);
  const Object& object = scene.objects[0];
  std::size_t glowing = 0;
  for (std::uint32_t i = 0; i < object.geometry.primitive_count(); ++i) {
    const Shape& shape = object.shape(i);
    if (shape.first_light == no_id) continue;
    ++glowing;
    const AreaLight light = std::get<AreaLight>(scene.lights.at(shape.first_light + i - shape.first_primitive));
    EXPECT_EQ(light.primitive, i);
    EXPECT_EQ(light.radiance, Rgb(2, 4, 6));
    EXPECT_TRUE(light.two_sided);
  }
  EXPECT_EQ(glowing, 2u) << "the first triangle and the sphere, not the second triangle";
  EXPECT_EQ(object.shape(1).first_light, no_id);
  EXPECT_EQ(light_of<AreaLight>("Attribute \"light\" \"float scale\" 5 AreaLightSource \"diffuse\"").radiance, Rgb(5));
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" \"string filename\" \"x.png\""), "cannot open 'x.png'");
  const Scene version3 =
      parse_pbrt("Film \"image\" WorldBegin LightSource \"point\" \"rgb I\" [2 2 2] \"float scale\" 5 " + triangle, "s.pbrt");
  EXPECT_EQ(std::get<PointLight>(version3.lights.at(0)).intensity, Rgb(2)) << "a scale of version 3 is a colour";
  EXPECT_TRUE(warns(version3, "LightSource \"point\": 'scale' has no effect, as in pbrt-v3, which expects a colour"));
}

TEST(PbrtLights, InfiniteLights) {
  const EnvironmentLight constant = light_of<EnvironmentLight>("LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" .5");
  expect_near(constant.scale, {0.5f, 1, 1.5f});
  EXPECT_TRUE(constant.texels.empty());

  const TestDirectory directory;
  Image image({4, 2});
  image.at(3, 1) = {7, 8, 9};
  write_exr(directory.path("wide.exr"), image);
  write_exr(directory.path("square.exr"), Image({4, 4}));
  const auto read = [&](const std::string& light) {
    return std::get<EnvironmentLight>(
        parse_pbrt("WorldBegin\nRotate 90 0 0 1\n" + light + triangle, directory.path("s.pbrt")).lights.at(0));
  };
  const EnvironmentLight version3 = read("LightSource \"infinite\" \"string mapname\" \"wide.exr\" \"rgb L\" [2 2 2]\n");
  EXPECT_EQ(version3.size, ivec2(4, 2));
  EXPECT_EQ(version3.texels.at(7), Rgb(7, 8, 9)) << "equirectangular as it stands";
  EXPECT_EQ(version3.scale, Rgb(2));
  expect_near(version3.light_to_world.vector({1, 0, 0}), {0, 1, 0});
  EXPECT_EQ(read("LightSource \"infinite\" \"string filename\" \"square.exr\"\n").size, ivec2(8, 4)) << "octahedral, unfolded";
  EXPECT_ERROR(read("LightSource \"infinite\" \"string filename\" \"wide.exr\"\n"), "expects a square octahedral image");
  EXPECT_ERROR(read("LightSource \"infinite\" \"string filename\" \"square.exr\" \"rgb L\" [1 1 1]\n"),
               "cannot stand beside 'filename'");
  EXPECT_ERROR(read("Scale 1 2 1 LightSource \"infinite\" \"string mapname\" \"wide.exr\"\n"), "distorts directions");
  EXPECT_ERROR(read("LightSource \"infinite\" \"point3 portal\" [0 0 0]\n"), "'portal' is not supported");
  image.at(1, 1) = {0, 1e35, 0};
  write_exr(directory.path("wide.exr"), image);
  for (const char* scale : {"1e-20", "1e4"})
    EXPECT_ERROR(read("LightSource \"infinite\" \"string mapname\" \"wide.exr\" \"float scale\" " + std::string(scale) + "\n"),
                 "'mapname' has a texel of");
}

TEST(PbrtLights, Version3InterpolatesTheTexelsOfEnvironments) {
  const TestDirectory directory;
  Image image({4, 2});
  image.at(0, 0) = {1, 1, 1};
  image.at(3, 1) = {8, 8, 8};
  write_exr(directory.path("sky.exr"), image);
  const auto read = [&](const std::string& film) {
    const std::string sky = " WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.exr\" ";
    return std::get<EnvironmentLight>(parse_pbrt(film + sky + triangle, directory.path("s.pbrt")).lights.at(0));
  };
  EXPECT_EQ(read("Film \"rgb\"").size, ivec2(4, 2));
  const EnvironmentLight fine = read("Film \"image\"");
  ASSERT_EQ(fine.size, ivec2(32, 16));
  const auto texel = [&](int x, int y) {
    return fine.texels.at(static_cast<std::size_t>(y) * 32 + static_cast<std::size_t>(x)).x;
  };
  // The centres of the coarse texels lie between their eighths, at 4, 12, 20 and 28 of these.
  EXPECT_FLOAT_EQ(texel(4, 0), 15.0f / 16) << "above the middle of the upper row nothing changes";
  EXPECT_FLOAT_EQ(texel(0, 0), 9.0f / 16) << "between the first column and, a turn on, the last";
  EXPECT_FLOAT_EQ(texel(28, 15), 8 * 15.0f / 16);
  EXPECT_FLOAT_EQ(texel(28, 8), 8 * (15.0f / 16) * (9.0f / 16) + (1.0f / 16) * (7.0f / 16));
  double sum = 0;
  for (const Rgb& value : fine.texels) sum += value.x;
  EXPECT_NEAR(sum / 64, 9, 1e-4) << "the light of all texels is kept";
}

TEST(PbrtSpectra, BlackbodiesHaveUnitLuminanceOrPeak) {
  for (const float kelvin : {2000.0f, 3500.0f, 6500.0f, 12000.0f}) {
    const Rgb rgb = light_of<EnvironmentLight>("LightSource \"infinite\" \"blackbody L\" " + std::to_string(kelvin)).scale;
    EXPECT_NEAR(luminance(rgb), 1, 0.003f) << kelvin;
  }
  const Rgb warm = blackbody_rgb(2700), day = blackbody_rgb(6504);
  expect_near(warm / warm.x, {1, 0.4241f, 0.0997f}, 0.02f);
  expect_near(day, Rgb(1, 1, 1), 0.08f);
  const Rgb version3 = light_of<EnvironmentLight>("LightSource \"infinite\" \"blackbody L\" [5000 3]").scale;
  expect_near(version3 / luminance(version3), blackbody_rgb(5000), 0.01f);
  EXPECT_GT(luminance(version3), 2.5f) << "near the peak over all of the visible range";
  EXPECT_LT(luminance(version3), 3);
  EXPECT_ERROR(light_of<EnvironmentLight>("LightSource \"infinite\" \"blackbody L\" 5"), "expected 100 to 1e6");
}

TEST(PbrtSpectra, SampledSpectraBecomeRgb) {
  const auto kd = [](const std::string& values) {
    return material_of<Diffuse>("Material \"matte\" \"spectrum Kd\" " + values).reflectance.constant;
  };
  expect_near(kd("[300 .4 900 .4]"), Rgb(0.4f), 1e-6f);
  // Version 4 has nothing beyond the ends, version 3 the end values.
  const Rgb green = kd("[500 1 600 1]");
  EXPECT_LT(green.z, 0.1f);
  EXPECT_GT(green.y, 0.9f);
  const auto sampled = [](const std::string& film, const std::string& material) {
    return parse_pbrt(film + " WorldBegin " + material + triangle, "s.pbrt").materials.at(0);
  };
  const std::string in_texture =
      "Texture \"t\" \"spectrum\" \"constant\" \"spectrum value\" [500 1 600 1] "
      "Material \"diffuse\" \"texture reflectance\" \"t\"";
  expect_near(std::get<Diffuse>(sampled("", in_texture)).reflectance.constant, green, 1e-6f);
  // In version 3 it is seen under light of equal energy, of which sRGB's white is no multiple.
  const Rgb pink(1.2048f, 0.9483f, 0.9089f);
  for (const float value : {0.5f, 1.0f}) {
    const std::string grey = fmt::format("Material \"matte\" \"spectrum Kd\" [500 {0} 600 {0}]", value);
    expect_near(std::get<Diffuse>(sampled("Film \"image\"", grey)).reflectance.constant, glm::min(value * pink, Rgb(1)), 0.01f);
  }
  const std::string metal = "Material \"conductor\" \"spectrum eta\" [500 2 600 2] \"spectrum k\" [500 3 600 3]";
  expect_near(std::get<Conductor>(sampled("", metal)).eta, Rgb(2), 1e-6f);
  const Rgb red = kd("[400 .05 580 .05 620 .9 700 .9]");
  EXPECT_GT(red.x, 0.7f);
  EXPECT_LT(red.y, 0.15f);
  EXPECT_LT(red.z, 0.1f);
  expect_near(light_of<PointLight>("LightSource \"point\" \"spectrum I\" \"stdillum-D65\" \"float scale\" 3").intensity,
              Rgb(3));
  EXPECT_NEAR(luminance(light_of<PointLight>("LightSource \"point\" \"spectrum I\" [300 9 900 9]").intensity), 1, 0.01f);
  // Version 4 has nothing beyond the ends; version 3 the end values, and takes the values for what they are.
  const auto light = [](const std::string& film, const std::string& values) {
    const Scene scene = parse_pbrt(film + " WorldBegin LightSource \"point\" \"spectrum I\" " + values + triangle, "s.pbrt");
    return std::get<PointLight>(scene.lights.at(0)).intensity;
  };
  EXPECT_LT(light("", "[500 2 570 2]").x, 0.01f);
  EXPECT_NEAR(luminance(light("", "[500 2 570 2]")), 1, 0.4f) << "less what lies outside sRGB";
  EXPECT_NEAR(luminance(light("Film \"image\"", "[500 2 570 2]")), 2, 0.02f);
  EXPECT_GT(light("Film \"image\"", "[500 2 570 2]").x, 1.8f);
  EXPECT_ERROR(kd("[400 .1 400 .2]"), "wavelengths must increase");
  EXPECT_ERROR(kd("[400 .1 500]"), "pairs of wavelength and value");
  EXPECT_ERROR(kd("\"stdillum-D65\""), "unknown spectrum 'stdillum-D65'");
  const TestDirectory directory;
  directory.write("grey.spd", "# grey\n380 0.3\n780 0.3 # end\n");
  const auto read = [&](const std::string& name) {
    return parse_pbrt("WorldBegin\nMaterial \"matte\" \"spectrum Kd\" \"" + name + "\"" + triangle, directory.path("s.pbrt"));
  };
  expect_near(std::get<Diffuse>(read("grey.spd").materials.at(0)).reflectance.constant, Rgb(0.3f));
  EXPECT_ERROR(read("absent.spd"), "cannot open");
}

}  // namespace
}  // namespace etendue
