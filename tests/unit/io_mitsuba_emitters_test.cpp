// Mitsuba scenes: emitters.
#include "framework/io/load_scene.h"
#include "framework/io/mitsuba/sky.h"
#include "framework/transport/light_sampling.h"
#include "tests/unit/io_mitsuba_helpers.h"

#include <fmt/format.h>

namespace etendue::mitsuba_test {
namespace {

TEST(MitsubaEmitters, AreReadAsOurs) {
  const Scene area =
      read("<shape type=\"rectangle\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"2\"/></emitter></shape>");
  ASSERT_EQ(area.lights.size(), 2u) << "one for each triangle";
  EXPECT_EQ(std::get<AreaLight>(area.lights[0]).radiance, Rgb(2));
  expect_near(
      light_of<DirectionalLight>("<emitter type=\"directional\"><vector name=\"direction\" value=\"0, -2, 0\"/></emitter>")
          .direction,
      {0, -1, 0});
  const auto spot =
      light_of<SpotLight>(R"(<emitter type="spot"><float name="cutoff_angle" value="30"/><transform name="to_world">
    <lookat origin="0, 3, 0" target="0, 0, 0" up="0, 0, 1"/></transform></emitter>)");
  EXPECT_EQ(spot.fade, SpotFade::linear);
  expect_near(spot.direction, {0, -1, 0});
  EXPECT_NEAR(spot.cos_inner, std::cos(22.5f * pi / 180), 1e-5);
  EXPECT_ERROR(read("<emitter type=\"spot\"><transform name=\"to_world\"><scale x=\"2\"/></transform></emitter>"),
               "'to_world' distorts the cone");
  EXPECT_ERROR(read("<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"0.1\"/></emitter>"), "expected 0.3");
  EXPECT_EQ(light_of<EnvironmentLight>("<emitter type=\"constant\"/>").scale, Rgb(1));
  EXPECT_ERROR(read("<emitter type=\"projector\"/>"), "is not supported");
  for (const auto& [type, why] :
       {std::pair("point", "has no place in a shape, only an area light has"), std::pair("projector", "is not supported")}) {
    const std::string lamp = "<shape type=\"sphere\"><emitter type=\"" + std::string(type) + "\"/></shape>";
    EXPECT_ERROR(read(lamp), "s.xml:2:22: emitter \"" + std::string(type) + "\" " + why);
    EXPECT_TRUE(approximated(lamp).lights.empty());
  }
  EXPECT_EQ(approximated(rectangle + "<emitter type=\"sunsky\"/>").lights.size(), 2u);
}

TEST(MitsubaEmitters, ShapesWithoutABsdfAreBlack) {
  const TestDirectory directory;
  directory.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string lamp = "<emitter type=\"area\"/>", white = "<rgb name=\"reflectance\" value=\"0.75\"/>",
                    mesh = "<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/>" + lamp + "</shape>";
  for (const char* version : {"0.6.0", "2.0.0", "3.0.0"}) {
    EXPECT_EQ(material_of<Diffuse>(lamp, version).reflectance.constant, Rgb(0)) << version;
    const Scene scene = parse_mitsuba(scene_text(mesh, version), directory.path("s.xml"));
    EXPECT_EQ(std::get<Diffuse>(scene.materials.at(0)).reflectance.constant, Rgb(0)) << version;
    EXPECT_EQ(material_of<Diffuse>(lamp + "<bsdf type=\"diffuse\">" + white + "</bsdf>", version).reflectance.constant,
              Rgb(0.75f));
  }
}

TEST(MitsubaEmitters, SkiesStandUprightAndSunsWhereTheyAreInTheWorld) {
  const Scene scene =
      approximated(rectangle + R"(<emitter type="sunsky"><vector name="sun_direction" x=".4" y="-.3" z=".85"/></emitter>)");
  ASSERT_EQ(scene.lights.size(), 2u);
  expect_near(std::get<DirectionalLight>(scene.lights[1]).direction, -glm::normalize(vec3(0.4f, -0.3f, 0.85f)));
  const LightSampler lights(scene);
  EXPECT_GT(luminance(lights.environment({0.1f, 0.1f, 0.99f})), 0);
  EXPECT_EQ(luminance(lights.environment({0.1f, 0.1f, -0.99f})), 0);
}

TEST(MitsubaEmitters, TheSunStandsWhereItStood) {
  const auto altitude = [](const vec3& towards) { return std::asin(towards.y) * 180 / pi; };
  const vec3 noon = towards_sun({2010, 6, 21, 12.0f, 51.4779f, 0, 0});  // Greenwich, at the solstice
  EXPECT_NEAR(altitude(noon), 90 - 51.4779 + 23.437, 0.1);
  EXPECT_GT(noon.z, 0) << "in the south";
  EXPECT_NEAR(noon.x, 0, 0.02);
  const vec3 morning = towards_sun({2010, 3, 20, 6.12f, 0, 0, 0});  // at the equator, at the equinox
  expect_near(morning, {1, 0, 0}, 0.02f);
  EXPECT_LT(towards_sun(SunTime()).x, -0.3f) << "a western sun in the afternoon";
  const Scene scene = approximated(rectangle + "<emitter type=\"sun\"><float name=\"hour\" value=\"9\"/></emitter>");
  EXPECT_GT(std::get<DirectionalLight>(scene.lights.at(0)).direction.y, 0.3f) << "from the east, where -y is";
}

// The middle of an envmap lies towards +z of Mitsuba's emitter space, and its top towards +y.
TEST(MitsubaEmitters, EnvironmentsAreTurnedIntoPlace) {
  const TestDirectory directory;
  std::string pixels;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 8; ++column)
      pixels += std::string({static_cast<char>(column * 30), static_cast<char>(row * 60), 0});
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(pixels.data());
  const auto png = encode_png(bytes, {8, 4});
  directory.write("e.png", std::string(png.begin(), png.end()));
  const Scene scene = load_scene(directory.write(
      "s.xml", scene_text("<emitter type=\"envmap\"><string name=\"filename\" value=\"e.png\"/></emitter>" + rectangle)));
  const auto& light = std::get<EnvironmentLight>(scene.lights.at(0));
  const auto texel = [&](const vec3& direction) {
    const vec3 d = light.light_to_world.inverse().vector(direction);
    const float u = std::atan2(d.y, d.x) / (2 * pi);
    return ivec2((u < 0 ? u + 1 : u) * 8, std::acos(d.z) / pi * 4);
  };
  EXPECT_EQ(texel(glm::normalize(vec3(-0.01f, 0.1f, 1))), ivec2(4, 1));
  EXPECT_EQ(texel(glm::normalize(vec3(1, 0.1f, 0.01f))), ivec2(2, 1));
  EXPECT_EQ(texel(glm::normalize(vec3(0.01f, 1, 0.02f))).y, 0);
  EXPECT_EQ(light.size, ivec2(64, 32)) << "interpolated between texels";
}

// Its `gamma` is the images' too, and from version 2 on the poles lie on the first row and the last.
TEST(MitsubaEmitters, EnvironmentsAreDecodedAndPlacedByVersion) {
  const TestDirectory directory;
  const std::vector<std::uint8_t> bytes{128, 128, 128, 128, 128, 128, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const auto png = encode_png(bytes.data(), {2, 3});
  directory.write("e.png", std::string(png.begin(), png.end()));
  const auto light = [&](const std::string& more, const std::string& version) {
    const std::string text = scene_text(
        "<emitter type=\"envmap\"><string name=\"filename\" value=\"e.png\"/>" + more + "</emitter>" + rectangle, version);
    return std::get<EnvironmentLight>(load_scene(directory.write("s.xml", text)).lights.at(0));
  };
  const std::string linear = "<float name=\"gamma\" value=\"1\"/>";
  EXPECT_NEAR(light("", "0.6.0").texels.at(0).x, 0.2159f, 1e-3f);
  EXPECT_NEAR(light(linear, "0.6.0").texels.at(0).x, 128.0f / 255, 1e-3f);
  // A PNG may say that it is linear itself, in a chunk after its header of 33 bytes; later versions do not ask.
  const std::string whole(png.begin(), png.end()), chunk("\0\0\0\4gAMA\0\1\x86\xa0\x31\xe8\x96\x5f", 16);
  directory.write("e.png", whole.substr(0, 33) + chunk + whole.substr(33));
  EXPECT_NEAR(light("", "0.6.0").texels.at(0).x, 128.0f / 255, 1e-3f);
  EXPECT_NEAR(light("", "3.0.0").texels.at(0).x, 0.2159f, 0.02f) << "of the first row below the pole";
  // Irradiance from above, over that of a sky as bright as the first row.
  const auto from_above = [&](const std::string& version) {
    const EnvironmentLight sky = light(linear, version);
    double sum = 0;
    for (int y = 0; y < sky.size.y / 2; ++y) {
      const double theta = pi * (y + 0.5) / sky.size.y;
      sum += sky.texels[static_cast<std::size_t>(y * sky.size.x)].x * std::sin(2 * theta) * pi / sky.size.y;
    }
    return sum / (128.0 / 255);
  };
  EXPECT_NEAR(from_above("3.0.0"), 0.5, 0.01);
  EXPECT_NEAR(from_above("0.6.0"), 2.220 / pi, 0.02);
}

}  // namespace
}  // namespace etendue::mitsuba_test
