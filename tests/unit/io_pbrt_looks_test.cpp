// Materials and textures.
#include "framework/core/elementary.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/spectra.h"
#include "framework/transport/light_sampling.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <fmt/format.h>

namespace etendue {
namespace {

TEST(PbrtMaterials, DiffuseAndDefault) {
  expect_near(material_of<Diffuse>("").reflectance.constant, Rgb(0.5f));
  expect_near(material_of<Diffuse>("Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]").reflectance.constant,
              {0.1f, 0.2f, 0.3f});
  expect_near(material_of<Diffuse>("Material \"matte\" \"color Kd\" [.1 .2 .3]").reflectance.constant, {0.1f, 0.2f, 0.3f});
  expect_near(material_of<Diffuse>("Material \"matte\" \"float Kd\" .25").reflectance.constant, Rgb(0.25f));
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"float sigma\" 20"), "'sigma' is not supported");
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"rgb Kd\" [.1 1.5 0]"), "has the component 1.5; expected 0 to 1");
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"rgb Kd\" [.1 .5]"), "has 2 values; expected three");
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"blackbody Kd\" 3000"), "only lights can be");
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"texture bumpmap\" \"x\""), "unknown float texture 'x'");
}

TEST(PbrtMaterials, ScopesAndNames) {
  const Scene scene = world(
      "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]\n"
      "MakeNamedMaterial \"unused\" \"string type\" \"mirror\"\n"
      "AttributeBegin NamedMaterial \"red\" " +
      triangle + " AttributeEnd " + triangle + "NamedMaterial \"red\"" + triangle);
  ASSERT_EQ(scene.materials.size(), 2u) << "unused ones are left out";
  const auto& shapes = scene.objects[0].shapes;
  EXPECT_EQ(shapes.at(0).material, shapes.at(2).material);
  EXPECT_NE(shapes.at(0).material, shapes.at(1).material);
  EXPECT_ERROR(world("MakeNamedMaterial \"red\" \"string type\" \"matte\"\nNamedMaterial \"rad\""),
               "s.pbrt:4:15: unknown named material 'rad'; did you mean 'red'");
  EXPECT_ERROR(world("MakeNamedMaterial \"red\""), "'type' is missing");
  const Scene twice = world(
      "MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"a\" \"string type\" \"mirror\" NamedMaterial "
      "\"a\"" +
      triangle);
  EXPECT_TRUE(warns(twice, "material 'a' is defined twice; the last one counts"));
  EXPECT_TRUE(std::holds_alternative<Conductor>(twice.materials.at(0)));
}

// In version 4 a name is the file's, wherever it is given.
TEST(PbrtMaterials, NamesOfVersion3EndWithTheirBlock) {
  const auto reflectances = [](const std::string& film) {
    const auto named = [](const std::string& of) {
      return "Texture \"t\" \"color\" \"constant\" \"rgb value\" " + of +
             " MakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\" ";
    };
    const std::string use_material = "NamedMaterial \"m\" " + triangle,
                      use_texture = "Material \"matte\" \"texture Kd\" \"t\" " + triangle;
    const Scene scene =
        parse_pbrt(film + " WorldBegin " + named("[.1 .1 .1]") + "AttributeBegin " + named("[.2 .2 .2]") + "TransformBegin " +
                       named("[.3 .3 .3]") + "TransformEnd " + use_material + "AttributeEnd " + use_material + use_texture,
                   "s.pbrt");
    std::vector<float> all;
    for (const Shape& shape : scene.objects[0].shapes)
      all.push_back(std::get<Diffuse>(scene.materials.at(shape.material)).reflectance.constant.x);
    return all;
  };
  EXPECT_EQ(reflectances("Film \"image\""), (std::vector<float>{0.3f, 0.1f, 0.1f}));
  EXPECT_EQ(reflectances("Film \"rgb\""), (std::vector<float>{0.3f, 0.3f, 0.3f}));
  EXPECT_ERROR(parse_pbrt("Film \"image\" WorldBegin AttributeBegin MakeNamedMaterial \"m\" \"string type\" \"matte\" "
                          "AttributeEnd NamedMaterial \"m\"",
                          "s.pbrt"),
               "unknown named material 'm'");
}

TEST(PbrtMaterials, ConductorsRemapRoughnessAsTheirVersionDoes) {
  const Conductor smooth = material_of<Conductor>("Material \"conductor\"");
  EXPECT_EQ(smooth.alpha, vec2(0));
  expect_near(smooth.eta, metals()[3].eta);
  EXPECT_EQ(metals()[3].name, "Cu");
  const Conductor version4 = material_of<Conductor>("Material \"conductor\" \"float uroughness\" .04 \"float vroughness\" .09");
  expect_near(vec3(version4.alpha, 0), {0.2f, 0.3f, 0});
  // The polynomial at log 0.1, in full precision.
  const double x = std::log(0.1),
               alpha = 1.62142 + 0.819955 * x + 0.1734 * x * x + 0.0171201 * x * x * x + 0.000640711 * x * x * x * x;
  const Conductor version3 = material_of<Conductor>("Material \"metal\" \"float roughness\" .1");
  EXPECT_NEAR(version3.alpha.x, alpha, 1e-5);
  const Conductor plain = material_of<Conductor>(
      "Material \"metal\" \"float roughness\" .1 \"bool remaproughness\" false \"rgb eta\" [1 2 3] \"rgb k\" [4 5 6]");
  EXPECT_EQ(plain.alpha, vec2(0.1f));
  EXPECT_EQ(plain.eta, Rgb(1, 2, 3));
  EXPECT_EQ(plain.k, Rgb(4, 5, 6));
  EXPECT_EQ(material_of<Conductor>("Material \"conductor\" \"float roughness\" .0001 \"bool remaproughness\" false").alpha,
            vec2(0))
      << "effectively smooth";
}

// Unpolarised reflectance at normal incidence.
Rgb normal_reflectance(const Rgb& eta, const Rgb& k) {
  return ((eta - 1.0f) * (eta - 1.0f) + k * k) / ((eta + 1.0f) * (eta + 1.0f) + k * k);
}

TEST(PbrtMaterials, NamedMetalsHaveTheColoursOfMetals) {
  const Conductor gold =
      material_of<Conductor>("Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"");
  expect_near(normal_reflectance(gold.eta, gold.k), {0.968f, 0.784f, 0.343f}, 0.01f);
  const Conductor silver =
      material_of<Conductor>("Material \"metal\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\"");
  expect_near(normal_reflectance(silver.eta, silver.k), {0.971f, 0.960f, 0.915f}, 0.01f);
  expect_near(normal_reflectance(metals()[3].eta, metals()[3].k), {0.953f, 0.639f, 0.538f}, 0.01f);
  const Conductor version3 = material_of<Conductor>("Material \"metal\"");
  expect_near(normal_reflectance(version3.eta, version3.k), {0.953f, 0.620f, 0.511f}, 0.01f);
  const Conductor tinted = material_of<Conductor>("Material \"conductor\" \"rgb reflectance\" [.9 .5 .1]");
  expect_near(normal_reflectance(tinted.eta, tinted.k), {0.9f, 0.5f, 0.1f});
  EXPECT_ERROR(material_of<Conductor>("Material \"conductor\" \"spectrum eta\" \"metal-Ax-eta\""),
               "unknown spectrum 'metal-Ax-eta'; did you mean 'metal-A");
  EXPECT_ERROR(material_of<Conductor>("Material \"conductor\" \"rgb reflectance\" .5"), "expected three");
  EXPECT_ERROR(material_of<Conductor>("Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb eta\" [1 1 1]"),
               "cannot stand beside");
  EXPECT_ERROR(material_of<Conductor>("Material \"metal\" \"rgb eta\" [0 1 1] \"rgb k\" [0 1 1]"), "both 0 in a channel");
}

TEST(PbrtMaterials, GlassMirrorAndPlastic) {
  const Conductor mirror = material_of<Conductor>("Material \"mirror\" \"rgb Kr\" [1 .5 .25]");
  EXPECT_TRUE(mirror.ideal);
  EXPECT_EQ(mirror.tint, Rgb(1, 0.5f, 0.25f));
  const Dielectric glass = material_of<Dielectric>("Material \"glass\" \"float index\" 1.6 \"rgb Kt\" [.5 1 1]");
  EXPECT_FLOAT_EQ(glass.eta, 1.6f);
  EXPECT_EQ(glass.transmit_tint, Rgb(0.5f, 1, 1));
  EXPECT_EQ(glass.alpha, 0) << "no roughness: smooth before the remapping";
  const auto rough_glass = [](const std::string& film) {
    return parse_pbrt(film + " WorldBegin Material \"glass\" \"float roughness\" .1 " + triangle, "s.pbrt");
  };
  EXPECT_GT(std::get<Dielectric>(rough_glass("").materials.at(0)).alpha, 0.1f);
  EXPECT_EQ(std::get<Dielectric>(rough_glass("Film \"image\"").materials.at(0)).alpha, 0)
      << "pbrt-v3 has it along u and v alone";
  EXPECT_TRUE(warns(rough_glass("Film \"image\""), "'roughness' has no effect"));
  EXPECT_GT(material_of<Dielectric>("Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1").alpha, 0.1f);
  EXPECT_FLOAT_EQ(material_of<Dielectric>("Material \"dielectric\" \"float roughness\" .25 \"float eta\" 1.33").alpha, 0.5f);
  EXPECT_FLOAT_EQ(material_of<Dielectric>("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").eta, 1.5168f);
  EXPECT_NEAR(material_of<Dielectric>("Material \"dielectric\" \"spectrum eta\" [300 1.5 800 1.5]").eta, 1.5f, 1e-4f);
  EXPECT_TRUE(warns(world("Material \"dielectric\" \"spectrum eta\" [300 1.5 800 1.5] " + triangle), "there is no dispersion"));
  EXPECT_ERROR(material_of<Dielectric>("Material \"dielectric\" \"spectrum eta\" \"glass-BK8\""),
               "unknown glass 'glass-BK8'; did you mean 'glass-BK7'");
  EXPECT_ERROR(material_of<Dielectric>("Material \"dielectric\" \"float uroughness\" .1"),
               "only conductors may be anisotropic");
  const Plastic coated = material_of<Plastic>(
      "Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float roughness\" 0.09 \"float thickness\" .1 \"integer "
      "maxdepth\" 5");
  EXPECT_FLOAT_EQ(coated.alpha, 0.3f);
  EXPECT_FLOAT_EQ(coated.coat.depth(), 0.1f);
  EXPECT_FLOAT_EQ(material_of<Plastic>("Material \"coateddiffuse\"").coat.depth(), 0.01f) << "pbrt's coats are not clear";
  EXPECT_EQ(coated.reflectance.constant, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_TRUE(warns(world("Material \"plastic\""), "conserves energy"));
  EXPECT_ERROR(material_of<Plastic>("Material \"plastic\" \"rgb Ks\" [1 .5 1]"), "a coloured 'Ks': coats reflect white");
  const auto plastic = [](const std::string& rough) {
    return parse_pbrt("Film \"image\" WorldBegin Material \"plastic\" " + rough + triangle, "s.pbrt");
  };
  const Scene by_axis = plastic("\"float uroughness\" .9 \"float vroughness\" .9 ");
  EXPECT_EQ(std::get<Plastic>(by_axis.materials.at(0)).alpha, std::get<Plastic>(plastic("").materials.at(0)).alpha);
  EXPECT_TRUE(warns(by_axis, "'vroughness' has no effect, as in pbrt-v3, which expects 'roughness'"));
  EXPECT_ERROR(material_of<Plastic>("Material \"coateddiffuse\" \"rgb albedo\" [.5 .5 .5]"), "'albedo' is not supported");
}

TEST(PbrtTextures, ConstantsFoldAndCombine) {
  const auto reflectance = [](const std::string& textures) {
    return material_of<Diffuse>(textures + " Material \"diffuse\" \"texture reflectance\" \"t\"").reflectance;
  };
  EXPECT_EQ(reflectance("Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]").constant, Rgb(0.1f, 0.2f, 0.3f));
  expect_near(reflectance("Texture \"a\" \"color\" \"constant\" \"rgb value\" [.5 .5 .5] Texture \"t\" \"color\" \"scale\" "
                          "\"texture tex1\" \"a\" \"rgb tex2\" [.2 1 1]")
                  .constant,
              {0.1f, 0.5f, 0.5f});
  expect_near(reflectance("Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] \"rgb tex2\" [1 .5 0] \"float amount\" .25")
                  .constant,
              {0.25f, 0.125f, 0});
  EXPECT_ERROR(reflectance("Texture \"x\" \"spectrum\" \"constant\""), "unknown spectrum texture 't'");
  EXPECT_ERROR(reflectance("Texture \"t\" \"float\" \"constant\""),
               "'reflectance' expects a spectrum texture, but 't' is a float texture");
  EXPECT_ERROR(reflectance("Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [2 2 2]"), "above 1");
  EXPECT_ERROR(world("Texture \"t\" \"vector\" \"constant\""), "unknown kind of texture 'vector'");
  EXPECT_TRUE(warns(world("Texture \"t\" \"float\" \"constant\" Texture \"t\" \"float\" \"constant\""),
                    "float texture 't' is defined twice; the last one counts"));
  EXPECT_FLOAT_EQ(
      material_of<Dielectric>(
          "Texture \"r\" \"float\" \"constant\" \"float value\" .25 Material \"dielectric\" \"texture roughness\" \"r\"")
          .alpha,
      0.5f);
}

std::string png_bytes(const std::vector<std::uint8_t>& rgb, ivec2 size) {
  const auto png = encode_png(rgb.data(), size);
  return {png.begin(), png.end()};
}

// Relief is turned inside out by it.
TEST(PbrtTextures, NumbersMayBeNegative) {
  const TestDirectory directory;
  directory.write("a.png", png_bytes({0, 0, 0, 255, 255, 255}, {2, 1}));
  const auto slope_of = [&](const std::string& scale, const std::string& textures) {
    const Scene scene = parse_pbrt("WorldBegin Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\" " + scale +
                                       textures + " Material \"diffuse\" \"texture displacement\" \"t\" " + triangle,
                                   directory.path("s.pbrt"));
    EXPECT_EQ(scene.reliefs.size(), 1u);
    return slope(scene.textures.at(scene.reliefs.at(0).texture), vec2(0.5f)).x;
  };
  const std::string by_number = "Texture \"t\" \"float\" \"scale\" \"texture tex\" \"a\" \"float scale\" ";
  // From 0 to 1 between the centres of two texels, half a unit of u apart.
  EXPECT_NEAR(slope_of("", by_number + "1"), 2, 1e-5f);
  EXPECT_NEAR(slope_of("", by_number + "-.1"), -0.2f, 1e-5f);
  EXPECT_NEAR(slope_of("\"float scale\" -2000 ", by_number + "1"), -4000, 1e-2f);
  const std::string constant = "Texture \"n\" \"float\" \"constant\" \"float value\" -.5 ";
  EXPECT_ERROR(world(constant + "Material \"conductor\" \"texture roughness\" \"n\""), "is -0.5; expected 0 to 1");
  EXPECT_ERROR(world("Texture \"n\" \"float\" \"constant\" \"float value\" -1e31"), "expected -1e30 to 1e30");
  EXPECT_ERROR(world("Texture \"c\" \"color\" \"constant\" \"rgb value\" [-1 0 0]"),
               "has the component -1; expected 0 to 1000");
  const Scene scaled = world(
      "Texture \"c\" \"color\" \"scale\" \"rgb tex\" [.5 .5 .5] \"float scale\" -1 Material \"diffuse\" \"texture "
      "reflectance\" "
      "\"c\" " +
      triangle);
  EXPECT_EQ(std::get<Diffuse>(scaled.materials.at(0)).reflectance.constant, Rgb(0));
  EXPECT_TRUE(warns(scaled, "falls to -0.5, less than a surface can reflect: clamped to 0"));
}

TEST(PbrtTextures, ValuesOfVersion3AreOfTheTexturesKind) {
  const auto reflectance = [](const std::string& film, const std::string& value) {
    const Scene scene = parse_pbrt(film + " WorldBegin Texture \"t\" \"color\" \"constant\" " + value +
                                       " Material \"matte\" \"texture Kd\" \"t\" " + triangle,
                                   "s.pbrt");
    return std::get<Diffuse>(scene.materials.at(0)).reflectance.constant;
  };
  EXPECT_EQ(reflectance("", "\"float value\" 0.25"), Rgb(0.25f));
  EXPECT_EQ(reflectance("Film \"image\"", "\"float value\" 0.25"), Rgb(1)) << "which is none of its colours";
  EXPECT_EQ(reflectance("Film \"image\"", "\"rgb value\" [.25 .25 .25]"), Rgb(0.25f));
  const Scene scene = parse_pbrt("Film \"image\" WorldBegin Texture \"f\" \"float\" \"constant\" \"rgb value\" [0 0 0] " +
                                     triangle.substr(0, triangle.size() - 1) + " \"texture alpha\" \"f\"",
                                 "s.pbrt");
  EXPECT_EQ(scene.objects[0].shapes.size(), 1u) << "alpha is 1";
  EXPECT_TRUE(warns(scene, "'value' has no effect, as in pbrt-v3, which expects a float"));
}

TEST(PbrtTextures, CheckerboardKeepsItsMapping) {
  const Scene scene = world(
      "Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [.1 .2 .3] \"float uscale\" 4 \"float vscale\" 2 \"float "
      "udelta\" .5\n"
      "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"float scale\" .5\n"
      "Material \"diffuse\" \"texture reflectance\" \"s\"" +
      triangle);
  ASSERT_EQ(scene.textures.size(), 1u);
  const CheckerTexture checker = std::get<CheckerTexture>(scene.textures[0]);
  expect_near(checker.even, {0.05f, 0.1f, 0.15f});
  EXPECT_EQ(checker.odd, Rgb(0));
  EXPECT_EQ(checker.uv_scale, vec2(4, 2));
  EXPECT_EQ(checker.uv_offset, vec2(0.5f, 0));
  const std::string checks = "Texture \"t\" \"spectrum\" \"checkerboard\" ";
  EXPECT_ERROR(world(checks + "\"string mapping\" \"conical\""), "expected uv, planar, spherical or cylindrical");
  EXPECT_ERROR(world(checks + " Material \"mirror\" \"texture Kr\" \"t\""), "'Kr' is a texture that varies");
  EXPECT_NEAR(approximate_material_of<Conductor>(checks + " Material \"mirror\" \"texture Kr\" \"t\"").tint.x, 1, 0.1f)
      << "its mean over the first square";
}

// A PNG of 2 x 1 texels, red of alpha 255 and white of alpha 128.
std::string png_with_alpha() {
  constexpr unsigned char bytes[] = {
      137, 80,  78,  71,  13,  10,  26,  10, 0,   0,   0,   13,  73,  72, 68, 82,  0, 0,  0,  2,  0,   0,   0,  1,   8,  6,
      0,   0,   0,   244, 34,  127, 138, 0,  0,   0,   20,  73,  68,  65, 84, 120, 1, 1,  9,  0,  246, 255, 0,  255, 0,  0,
      255, 255, 255, 255, 128, 22,  115, 5,  124, 100, 135, 217, 234, 0,  0,  0,   0, 73, 69, 78, 68,  174, 66, 96,  130};
  return {std::begin(bytes), std::end(bytes)};
}

TEST(PbrtTextures, NumbersAreTheAlphaOfAnImageInVersion4) {
  const TestDirectory directory;
  directory.write("a.png", png_with_alpha());
  const auto mask = [&](const std::string& film, const std::string& params = "") {
    const std::string holed = triangle.substr(0, triangle.size() - 1) + " \"texture alpha\" \"t\"";
    const Scene scene =
        parse_pbrt(film + " WorldBegin Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"a.png\" " + params + holed,
                   directory.path("s.pbrt"));
    return std::get<ImageTexture>(scene.textures.at(0)).texels;
  };
  EXPECT_EQ(mask("").at(0), Rgb(1));
  EXPECT_NEAR(mask("").at(1).x, 0.2158605f, 1e-6f) << "encoded like its colours";
  EXPECT_NEAR(mask("", "\"string encoding\" \"linear\"").at(1).x, 128 / 255.0f, 1e-6f);
  const std::string version3 = "Film \"image\"";
  EXPECT_NEAR(mask(version3, "\"bool gamma\" \"false\"").at(0).y, 0.2126f, 1e-4f) << "of its colours the luminance, no alpha";
  EXPECT_NEAR(mask(version3).at(0).y, 0.0371f, 2e-4f) << "which is decoded then";
  EXPECT_NEAR(mask(version3).at(1).y, 1, 1e-6f);
}

TEST(PbrtTextures, ImagesAreDecodedOnce) {
  const TestDirectory directory;
  directory.write("maps/a.png", png_bytes({255, 0, 188, 0, 0, 0}, {2, 1}));
  const auto image = [&](const std::string& params) {
    const std::string text = "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"maps/a.png\" " + params +
                             " Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle + triangle;
    const Scene scene = parse_pbrt(text, directory.path("s.pbrt"));
    EXPECT_EQ(scene.textures.size(), 1u);
    return std::get<ImageTexture>(scene.textures.at(0));
  };
  EXPECT_NEAR(image("").texels.at(0).z, 0.5028865, 1e-6);
  EXPECT_EQ(image("").size, ivec2(2, 1));
  EXPECT_NEAR(image("\"string encoding\" \"linear\" \"float scale\" .5").texels.at(0).z, 188.0 / 255, 1e-6);
  EXPECT_NEAR(image("\"bool gamma\" \"false\"").texels.at(0).z, 188.0 / 255, 1e-6);
  EXPECT_EQ(image("\"float scale\" .5 \"bool trilinear\" true \"string filter\" \"trilinear\" \"string wrap\" \"repeat\"").gain,
            0.5f);
  EXPECT_EQ(image("\"bool invert\" true").texels.at(0), Rgb(0, 1, 1 - image("").texels.at(0).z));
  EXPECT_ERROR(image("\"string wrap\" \"mirror\""), "expected repeat, clamp or black");
  EXPECT_ERROR(image("\"string encoding\" \"gamma of 2\""), "expected sRGB, linear or gamma with a number");
  EXPECT_ERROR(parse_pbrt("WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"absent.png\"",
                          directory.path("s.pbrt")),
               "s.pbrt:2:35: cannot open");
}

TEST(PbrtTextures, WhatIsInvertedIsWhiteWhereItWouldBeBlack) {
  const TestDirectory directory;
  directory.write("a.png", png_bytes({188, 188, 188}, {1, 1}));
  const auto reflectance = [&](const std::string& invert, const vec2& uv) {
    const Scene scene = parse_pbrt(
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string wrap\" \"black\" \"float "
        "uscale\" 2 \"float vscale\" 2 " +
            invert +
            " Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
        directory.path("s.pbrt"));
    return evaluate(scene.textures.at(std::get<Diffuse>(scene.materials.back()).reflectance.texture), uv).x;
  };
  const std::string invert = "\"bool invert\" true";
  EXPECT_NEAR(reflectance(invert, vec2(0.25f)), 1 - 0.5028865f, 1e-3f);
  EXPECT_NEAR(reflectance(invert, vec2(0.9f)), 1, 1e-3f);
  EXPECT_EQ(reflectance("", vec2(0.9f)), 0);
}

TEST(PbrtTextures, Version4AsksForTheEncodingOfPngAlone) {
  const TestDirectory directory;
  directory.write("a.tga", std::string("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0\xbc\xbc\xbc", 21));
  const auto read = [&](const std::string& film, const std::string& params) {
    return parse_pbrt(film + " WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.tga\" " + params +
                          " Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle,
                      directory.path("s.pbrt"));
  };
  const auto texel = [](const Scene& scene) { return std::get<ImageTexture>(scene.textures.at(0)).texels.at(0).x; };
  const Scene linear = read("", "\"string encoding\" \"linear\"");
  EXPECT_NEAR(texel(linear), 0.5028865, 1e-6);
  EXPECT_TRUE(warns(linear, "'encoding' has no effect, as in pbrt-v4"));
  EXPECT_FALSE(warns(read("", "\"string encoding\" \"sRGB\""), "encoding"));
  EXPECT_NEAR(texel(read("Film \"image\"", "\"bool gamma\" \"false\"")), 188.0 / 255, 1e-6);
  EXPECT_TRUE(
      warns(parse_pbrt("WorldBegin Material \"diffuse\" \"string normalmap\" \"a.tga\" " + triangle, directory.path("s.pbrt")),
            "the normals of 'a.tga' are its values as they are"));
}

TEST(PbrtTextures, ImagesStandUprightOverV) {
  // (0, 0) is the lower left corner of the image, whose first row in the file is the uppermost.
  const TestDirectory directory;
  directory.write("a.png", png_bytes({255, 0, 0, 0, 0, 255}, {1, 2}));
  const Scene scene = parse_pbrt(
      "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\""
      " Material \"diffuse\" \"texture reflectance\" \"t\" " +
          triangle,
      directory.path("s.pbrt"));
  EXPECT_EQ(evaluate(scene.textures.at(0), {0.5f, 0.75f}), Rgb(1, 0, 0));
  EXPECT_EQ(evaluate(scene.textures.at(0), {0.5f, 0.25f}), Rgb(0, 0, 1));
  EXPECT_EQ(evaluate(scene.textures.at(0), {0.5f, 0.5f}), Rgb(0.5f, 0, 0.5f));
}

TEST(PbrtTextures, PointSampledImagesHaveEdgesBetweenTexels) {
  const TestDirectory directory;
  directory.write("a.png", png_bytes({255, 0, 0, 0, 0, 255}, {1, 2}));
  directory.write("b.png", png_bytes(std::vector<std::uint8_t>(std::size_t{3} * 128 * 64, 255), {128, 64}));
  const auto textured = [&](const std::string& file) {
    return parse_pbrt("WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + file +
                          "\" \"string filter\" \"point\" Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle,
                      directory.path("s.pbrt"));
  };
  const Scene scene = textured("a.png");
  EXPECT_EQ(evaluate(scene.textures.at(0), {0.5f, 0.54f}), Rgb(1, 0, 0));
  EXPECT_EQ(evaluate(scene.textures.at(0), {0.5f, 0.46f}), Rgb(0, 0, 1));
  EXPECT_FALSE(warns(scene, "interpolated"));
  EXPECT_TRUE(warns(textured("b.png"), "interpolated over 1/11 of a texel at the edges of each"));
}

// An albedo above 1 makes light out of nothing; under a coat, whose reflections inside are summed, it made NaN.
TEST(PbrtTextures, ReflectancesAreClampedToWhatASurfaceCanReflect) {
  const TestDirectory directory;
  Image image({2, 2});
  image.pixels = {{2, 0.5, -1}, {std::numeric_limits<double>::quiet_NaN(), 1, 0.25}, {1e30, 1, 1}, {0.5, 0.5, 0.5}};
  write_exr(directory.path("own values.exr"), image);
  const std::string begin =
      "WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"own values.exr\" \"float scale\" 1e9\n";
  const std::string coat = "Material \"coateddiffuse\" \"texture reflectance\" \"t\" " + triangle;
  const Scene scene = parse_pbrt(begin + coat, directory.path("s.pbrt"));
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const Rgb value = evaluate(scene.textures.at(0), vec2(x, y) / 8.0f - 0.3f);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(value[c] >= 0 && value[c] <= 1) << value[c];
    }
  EXPECT_TRUE(warns(scene, "s.pbrt:2:35: 'own values.exr' holds NaN or infinity in 1 texels"));
  EXPECT_TRUE(warns(scene, "s.pbrt:3:26: texture 't' of 'own values.exr' reaches inf, more than")) << scene.warnings.back();
  EXPECT_TRUE(warns(scene, "texture 't' of 'own values.exr' falls to -1e+09, less than"));
  // A later scaling takes the file's own value, even if a surface has used it before.
  const std::string scaled =
      "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"float scale\" .25 Material \"diffuse\" \"texture "
      "reflectance\" "
      "\"s\" " +
      triangle;
  image.pixels = {4, dvec3(2, 1, 0.4)};
  write_exr(directory.path("own values.exr"), image);
  const std::string plain = begin.substr(0, begin.find(" \"float scale\"")) + "\n";
  const Scene both = parse_pbrt(plain + coat + scaled, directory.path("s.pbrt"));
  expect_near(evaluate(both.textures.at(0), vec2(0.5f)), {1, 1, 0.4f});
  expect_near(evaluate(both.textures.at(1), vec2(0.5f)), {0.5f, 0.25f, 0.1f});
  const auto clamped = std::count_if(both.warnings.begin(), both.warnings.end(),
                                     [](const std::string& warning) { return warning.find("clamped") != std::string::npos; });
  EXPECT_EQ(clamped, 1) << "only the one that exceeds 1";
  const Scene checks = world("Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [3 1 0] " + coat);
  EXPECT_EQ(evaluate(checks.textures.at(0), vec2(0.5f)), Rgb(1, 1, 0));
  EXPECT_TRUE(warns(checks, "texture 't' reaches 3, more than a surface can reflect: clamped to 1"));
}

// 1000 to the 13th is infinite, and that times 0 is NaN: neither less than 0 nor more than 1.
TEST(PbrtTextures, ReflectancesThatOverflowToNanAreZero) {
  std::string scales;
  const auto scale = [&](int i, const char* factor) {
    scales +=
        fmt::format("Texture \"t{}\" \"spectrum\" \"scale\" \"texture tex\" \"t{}\" \"rgb scale\" [{}]\n", i, i - 1, factor);
  };
  for (int i = 1; i <= 13; ++i) scale(i, "1000 1000 1000");
  scale(14, "0 0 0");
  const std::string surface = "Material \"diffuse\" \"texture reflectance\" \"t14\" " + triangle;
  const Scene scene = world("Texture \"t0\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0.5 0]\n" + scales + surface);
  for (const vec2& uv : {vec2(0.5f), vec2(1.5f, 0.5f)}) EXPECT_EQ(evaluate(scene.textures.at(0), uv), Rgb(0));
  EXPECT_TRUE(warns(scene, "texture 't14' holds NaN"));
  EXPECT_ERROR(world("Texture \"t0\" \"spectrum\" \"constant\" \"rgb value\" [1 0.5 0]\n" + scales + surface),
               "'reflectance' is a texture of a value that is not finite");
}

TEST(PbrtTextures, PlacesBeyondSinglePrecisionHaveAValue) {
  EXPECT_EQ(evaluate(ImageTexture{.size = {1, 1}, .texels = {Rgb(0.5f)}, .uv_scale = vec2(1e30f)}, vec2(1e30f)), Rgb(0.5f));
}

}  // namespace
}  // namespace etendue
