// Relief and lights with images, as pbrt and Mitsuba scenes state them.
#include "framework/io/image/image_file.h"
#include "framework/io/load_scene.h"
#include "tests/unit/io_mitsuba_helpers.h"
#include "tests/unit/io_pbrt_helpers.h"

namespace etendue {
namespace {

// Shading normal in the middle of the first triangle.
vec3 normal_of(const Scene& scene) {
  const Hit hit{.t = 1, .uv = {0.3f, 0.3f}, .instance = 0, .primitive = 0};
  return scene.surface_at(Ray{.origin = {0, 0, 5}, .direction = {0, 0, -1}}, hit).shading_normal;
}

class Looks : public ::testing::Test {
 protected:
  // A column of black and one of white; a normal that leans along +x.
  Looks() {
    write("ramp.png", {0, 0, 0, 255, 255, 255}, {2, 1});
    write("lean.png", {204, 128, 230}, {1, 1});
  }
  void write(const std::string& name, const std::vector<std::uint8_t>& values, ivec2 size) {
    const auto png = encode_png(values.data(), size);
    directory.write(name, std::string(png.begin(), png.end()));
  }
  Scene pbrt(const std::string& text, bool approximate = false) const {
    return parse_pbrt("WorldBegin " + text, directory.path("s.pbrt"), {.approximate = approximate});
  }
  Scene mitsuba(const std::string& inside, const std::string& version = "3.0.0") {
    return load_scene(directory.write("s.xml", mitsuba_test::scene_text(inside, version)));
  }

  TestDirectory directory;
};

const std::string ramp =
    "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"ramp.png\" \"string encoding\" \"linear\" ";

TEST_F(Looks, PbrtHeightsTurnNormals) {
  for (const char* material :
       {"Material \"matte\" \"texture bumpmap\" \"t\" ", "Material \"diffuse\" \"texture displacement\" \"t\" "}) {
    // The default (u, v) of a triangle: u along (0, 0, 0) to (1, 0, 0), v along (1, 0, 0) to (0, 1, 0). Heights rise by 2 over
    // u.
    const vec3 n = normal_of(pbrt(ramp + material + triangle));
    const vec3 along_u(1, 0, 2), along_v(-1, 1, 0);
    expect_near(n, glm::normalize(glm::cross(along_u, along_v)), 1e-4f);
  }
  EXPECT_ERROR(pbrt("Material \"matte\" \"texture bumpmap\" \"s\""), "unknown float texture 's'");
  EXPECT_TRUE(pbrt("Material \"matte\" \"float bumpmap\" 3 " + triangle).reliefs.empty());
}

TEST_F(Looks, PbrtHeightsThatDependOnThePlaceAreBaked) {
  const std::string windy =
      "Texture \"t\" \"float\" \"windy\" Material \"plastic\" \"texture bumpmap\" \"t\" \"texture Kd\" \"c\" ";
  const std::string checks = "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [.1 .2 .3] \"rgb tex2\" [.4 .5 .6] ";
  const Scene scene = pbrt(checks + windy + "Shape \"sphere\" ");
  ASSERT_EQ(scene.reliefs.size(), 1u);
  EXPECT_EQ(scene.textures.at(scene.reliefs[0].texture).index(), 0u) << "an image";
  const Shape& shape = scene.objects[0].shapes.at(0);
  EXPECT_EQ(scene.objects[0].uvs.size(), 3 * scene.objects[0].geometry.triangles.size());
  EXPECT_EQ(shape.relief, 0u);
  EXPECT_NE(std::get<Plastic>(scene.materials[shape.material]).reflectance.texture, scene.reliefs[0].texture);
}

TEST_F(Looks, PbrtHeightsThatAreAnAlphaAsWellAreNotClamped) {
  const std::string dots = "Texture \"d\" \"float\" \"dots\" \"float inside\" 5 \"float uscale\" 8 \"float vscale\" 8 ";
  const Scene scene =
      pbrt(dots + "Material \"diffuse\" \"texture displacement\" \"d\" Shape \"sphere\" \"texture alpha\" \"d\"");
  const auto most = [&](std::uint32_t texture) {
    const auto& texels = std::get<ImageTexture>(scene.textures.at(texture)).texels;
    return std::ranges::max_element(texels, {}, [](const Rgb& texel) { return texel.x; })->x;
  };
  EXPECT_EQ(most(scene.reliefs.at(0).texture), 5);
  EXPECT_EQ(most(scene.objects[0].shapes.at(0).mask), 1);
}

TEST_F(Looks, PbrtNormalMapsAreImageFiles) {
  const vec3 n = normal_of(pbrt("Material \"diffuse\" \"string normalmap\" \"lean.png\" " + triangle));
  expect_near(n, glm::normalize(vec3(0.6f, 0.0039f, 0.804f)), 1e-2f);
}

TEST_F(Looks, PbrtNormalMapsHideDisplacementInVersion4) {
  const Scene scene =
      pbrt(ramp + "Material \"diffuse\" \"texture displacement\" \"t\" \"string normalmap\" \"lean.png\" " + triangle);
  expect_near(normal_of(scene), glm::normalize(vec3(0.6f, 0.0039f, 0.804f)), 1e-2f);
  EXPECT_TRUE(warns(scene, "'displacement' has no effect beside 'normalmap', as in pbrt-v4"));
}

TEST_F(Looks, PbrtLightsShowTheirImage) {
  const Scene scene =
      pbrt("AreaLightSource \"diffuse\" \"string filename\" \"ramp.png\" \"rgb L\" [6 3 0] " + triangle + "Shape \"sphere\" ");
  const auto& light = std::get<AreaLight>(scene.lights.at(0));
  ASSERT_NE(light.texture, no_id);
  expect_near(light.radiance * evaluate(scene.textures[light.texture], {0.75f, 0.5f}), Rgb(6, 3, 0), 1e-4f);
  expect_near(evaluate(scene.textures[light.texture], {2, 0.5f}), Rgb(1), 1e-6f);
  EXPECT_TRUE(scene.objects[0].geometry.quadrics.empty()) << "the sphere has become a mesh";
  EXPECT_TRUE(scene.objects[0].shapes.at(0).uses_uvs);
  const Scene both = pbrt(
      "Texture \"t\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 Material \"diffuse\" \"texture reflectance\" \"t\" "
      "AreaLightSource \"diffuse\" \"string filename\" \"ramp.png\" " +
          triangle,
      true);
  EXPECT_TRUE(both.objects[0].shapes.at(0).uses_uvs) << "whatever its material is";
}

TEST_F(Looks, PbrtImagesEndAsTheFileSays) {
  const std::string image = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"ramp.png\" \"string wrap\" ";
  const std::string use = " Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle;
  EXPECT_EQ(evaluate(pbrt(image + "\"clamp\"" + use).textures.at(0), {3, 0.5f}), Rgb(1));
  EXPECT_EQ(evaluate(pbrt(image + "\"black\"" + use).textures.at(0), {3, 0.5f}), Rgb(0));
}

std::string mitsuba_image(const std::string& name, const std::string& file, const std::string& more = "") {
  return "<texture name=\"" + name +
         "\" type=\"bitmap\"><boolean name=\"raw\" value=\"true\"/><string name=\"filename\" value=\"" + file + "\"/>" + more +
         "</texture>";
}

TEST_F(Looks, MitsubaReliefTurnsNormals) {
  const auto on_rectangle = [](const std::string& bsdf) { return "<shape type=\"rectangle\">" + bsdf + "</shape>"; };
  // The rectangle is 2 wide, so that the slope is 2 * 0.5 / 2.
  const std::string bumps = "<bsdf type=\"twosided\"><bsdf type=\"bumpmap\"><float name=\"scale\" value=\"0.5\"/>" +
                            mitsuba_image("any", "ramp.png") + "<bsdf type=\"diffuse\"/></bsdf></bsdf>";
  expect_near(normal_of(mitsuba(on_rectangle(bumps))), glm::normalize(vec3(-0.5f, 0, 1)), 1e-4f);
  // Heights of a coloured image are its luminance.
  write("blue.png", {0, 0, 0, 0, 0, 255}, {2, 1});
  const std::string blue = "<bsdf type=\"bumpmap\">" + mitsuba_image("any", "blue.png") + "<bsdf type=\"diffuse\"/></bsdf>";
  expect_near(normal_of(mitsuba(on_rectangle(blue))), glm::normalize(vec3(-0.0722f, 0, 1)), 1e-3f);
  expect_near(normal_of(mitsuba(on_rectangle(blue), "0.6.0")), glm::normalize(vec3(-0.0722f, 0, 1)), 1e-3f);
  const std::string normals =
      "<bsdf type=\"normalmap\">" + mitsuba_image("normalmap", "lean.png") + "<bsdf type=\"roughconductor\"/></bsdf>";
  expect_near(normal_of(mitsuba(on_rectangle(normals))), glm::normalize(vec3(0.6f, 0.0039f, 0.804f)), 1e-2f);
  EXPECT_ERROR(mitsuba(on_rectangle("<bsdf type=\"bumpmap\"><bsdf type=\"diffuse\"/></bsdf>")), "has 0 textures in it");
  EXPECT_GT(mitsuba("<shape type=\"sphere\">" + normals + "</shape>").objects[0].geometry.triangles.size(), 0u);
}

TEST_F(Looks, MitsubaLightsShowTheirImage) {
  const Scene scene = mitsuba("<shape type=\"rectangle\"><emitter type=\"area\">" + mitsuba_image("radiance", "ramp.png") +
                              "</emitter></shape>");
  const auto& light = std::get<AreaLight>(scene.lights.at(0));
  ASSERT_NE(light.texture, no_id);
  expect_near(light.radiance * evaluate(scene.textures[light.texture], {0.25f, 0.5f}), Rgb(0), 1e-6f);
  expect_near(light.radiance * evaluate(scene.textures[light.texture], {0.75f, 0.5f}), Rgb(1), 1e-6f);
}

TEST_F(Looks, MitsubaImagesEndAsTheFileSays) {
  const auto beyond = [&](const std::string& wrap) {
    const std::string image = mitsuba_image("reflectance", "ramp.png", "<string name=\"wrap_mode\" value=\"" + wrap + "\"/>");
    return evaluate(mitsuba("<shape type=\"rectangle\"><bsdf type=\"diffuse\">" + image + "</bsdf></shape>").textures.at(0),
                    {1.75f, 0.5f})
        .x;
  };
  EXPECT_EQ(beyond("repeat"), 1);
  EXPECT_EQ(beyond("mirror"), 0);
  EXPECT_EQ(beyond("clamp"), 1);
  EXPECT_EQ(beyond("zero"), 0);
  EXPECT_ERROR(beyond("one"), "'wrap_mode' is 'one'");
}

TEST_F(Looks, MitsubaRoughnessIsBeckmannsUnlessItIsGgx) {
  const auto distribution = [](const std::string& inside) {
    return mitsuba_test::material_of<Conductor>("<bsdf type=\"roughconductor\">" + inside + "</bsdf>").distribution;
  };
  EXPECT_EQ(distribution(""), NormalDistribution::beckmann);
  EXPECT_EQ(distribution("<string name=\"distribution\" value=\"ggx\"/>"), NormalDistribution::ggx);
  EXPECT_ERROR(distribution("<string name=\"distribution\" value=\"phong\"/>"), "expected ggx or beckmann");
  EXPECT_EQ(mitsuba_test::material_of<Plastic>("<bsdf type=\"roughplastic\"/>").distribution, NormalDistribution::beckmann);
  EXPECT_EQ(mitsuba_test::material_of<Dielectric>("<bsdf type=\"roughdielectric\"/>").distribution,
            NormalDistribution::beckmann);
}

}  // namespace
}  // namespace etendue
