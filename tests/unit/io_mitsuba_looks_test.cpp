// Mitsuba scenes: bsdfs, colours and textures.
#include "framework/io/image/image_file.h"
#include "framework/io/load_scene.h"
#include "framework/io/spectra.h"
#include "tests/unit/io_mitsuba_helpers.h"

#include <fmt/format.h>

namespace etendue::mitsuba_test {
namespace {

TEST(MitsubaBsdfs, AreReadAsOurs) {
  EXPECT_EQ(material_of<Diffuse>("").reflectance.constant, Rgb(0.5f)) << "without a bsdf";
  EXPECT_NEAR(material_of<Dielectric>("<bsdf type=\"dielectric\"/>").eta, 1.5046f / 1.00028f, 1e-4);
  EXPECT_NEAR(
      material_of<Dielectric>(
          "<bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"water\"/><float name=\"extIOR\" value=\"1\"/></bsdf>")
          .eta,
      1.333f, 1e-4);
  const std::string in_capitals =
      "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"BK7\"/><string name=\"ext_ior\" value=\"Vacuum\"/></bsdf>";
  EXPECT_NEAR(material_of<Dielectric>(in_capitals).eta, 1.5046f, 1e-4);
  EXPECT_TRUE(material_of<Conductor>("<bsdf type=\"conductor\"/>").ideal) << "version 3";
  EXPECT_EQ(material_of<Conductor>("<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>").eta,
            metals()[2].eta);
  const auto rough = material_of<Conductor>(
      "<bsdf type=\"twosided\"><bsdf type=\"roughconductor\"><string name=\"distribution\" value=\"GGX\"/><float "
      "name=\"alphaU\" value=\"0.2\"/><float name=\"alphaV\" value=\"0.1\"/></bsdf></bsdf>");
  EXPECT_EQ(rough.alpha, vec2(0.2f, 0.1f));
  EXPECT_EQ(rough.distribution, NormalDistribution::ggx) << "in capitals";
  EXPECT_EQ(material_of<Conductor>("<bsdf type=\"roughconductor\"/>").alpha, vec2(0.1f));
  EXPECT_ERROR(material_of<Conductor>("<bsdf type=\"conductor\"><string name=\"material\" value=\"Aq\"/></bsdf>"),
               "unknown metal 'Aq'");
  EXPECT_ERROR(material_of<Dielectric>("<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"watr\"/></bsdf>"),
               "unknown material 'watr'; did you mean 'water'");
  EXPECT_TRUE(read("<shape type=\"sphere\"><bsdf type=\"null\"/></shape>").objects[0].shapes.empty());
  const auto mixed = material_of<Diffuse>(R"(<bsdf type="blendbsdf"><float name="weight" value="0.25"/>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf><bsdf type="diffuse"><rgb name="reflectance" value="0.4"/></bsdf></bsdf>)");
  expect_near(mixed.reflectance.constant, Rgb(0.7f));
  const auto pane = material_of<Dielectric>(R"(<bsdf type="thindielectric"><float name="int_ior" value="1.6"/>
    <float name="ext_ior" value="1"/><rgb name="specular_transmittance" value="0.5"/></bsdf>)");
  EXPECT_TRUE(pane.thin);
  EXPECT_FLOAT_EQ(pane.eta, 1.6f);
  EXPECT_EQ(pane.transmit_tint, Rgb(0.5f));
  const auto leaf =
      material_of<DiffuseTransmission>("<bsdf type=\"difftrans\"><rgb name=\"transmittance\" value=\"0.3\"/></bsdf>");
  EXPECT_EQ(leaf.reflectance.constant, Rgb(0));
  EXPECT_EQ(leaf.transmittance.constant, Rgb(0.3f));
}

TEST(MitsubaBsdfs, MixturesOfOneKindAreExact) {
  const auto metal = [](const char* tint, const char* alpha) {
    return fmt::format(
        R"(<bsdf type="roughconductor"><float name="alpha" value="{}"/><rgb name="specular_reflectance" value="{}"/></bsdf>)",
        alpha, tint);
  };
  const auto blend = [](const std::string& a, const std::string& b) {
    return "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/>" + a + b + "</bsdf>";
  };
  expect_near(material_of<Conductor>(blend(metal("0.8", "0.2"), metal("0.4", "0.2"))).tint, Rgb(0.7f));
  EXPECT_ERROR(material_of<Conductor>(blend(metal("0.8", "0.2"), metal("0.4", "0.3"))), "alike but for constant colours");
  const auto plastic = [](const char* base) {
    return fmt::format(R"(<bsdf type="plastic"><rgb name="diffuse_reflectance" value="{}"/></bsdf>)", base);
  };
  // Linear plastic looks as bright as its reflectance says.
  expect_near(material_of<Plastic>(blend(plastic("0.8"), plastic("0.4"))).reflectance.constant,
              material_of<Plastic>(plastic("0.7")).reflectance.constant);
  const auto mixture = [&](const char* weights) {
    return fmt::format(R"(<bsdf type="mixturebsdf"><string name="weights" value="{}"/>{}{}{}</bsdf>)", weights,
                       metal("1", "0.2"), metal("0.5", "0.2"), metal("0", "0.2"));
  };
  expect_near(material_of<Conductor>(mixture("0.5, 0.3, 0.2"), "0.6.0").tint, Rgb(0.65f));
  EXPECT_ERROR(material_of<Conductor>(mixture("0.5, 0.3, 0.1"), "0.6.0"), "mixturebsdf");
}

// Mitsuba's plastic without `nonlinear` divides by 1 - F, ours by 1 - albedo F.
TEST(MitsubaBsdfs, OneSidedOnesAreCounted) {
  const auto warned = [](const std::string& shapes) {
    std::string all;
    for (const std::string& warning : read(shapes).warnings) all += warning + "\n";
    return all;
  };
  const std::string one = rectangle, two = rectangle + rectangle;
  EXPECT_NE(warned(one).find(": one shape has a bsdf without twosided"), std::string::npos) << warned(one);
  EXPECT_NE(warned(two).find(": 2 shapes have a bsdf without twosided"), std::string::npos) << warned(two);
}

TEST(MitsubaBsdfs, LinearPlasticKeepsItsReflectance) {
  const std::string inside = "<rgb name=\"diffuse_reflectance\" value=\"0.5\"/>";
  const auto linear = material_of<Plastic>("<bsdf type=\"plastic\">" + inside + "</bsdf>");
  const auto nonlinear =
      material_of<Plastic>("<bsdf type=\"plastic\">" + inside + "<boolean name=\"nonlinear\" value=\"true\"/></bsdf>");
  const float f = linear.coat.internal_reflectance(), a = linear.reflectance.constant.x;
  EXPECT_EQ(nonlinear.reflectance.constant, Rgb(0.5f));
  EXPECT_NEAR(a / (1 - a * f), 0.5f / (1 - f), 1e-5);
}

TEST(MitsubaBsdfs, WhatCannotBeIsRefusedOrApproximated) {
  for (const char* type : {"phong", "ward", "principled", "roughdiffuse", "hk", "measured", "pplastic", "polarizer"}) {
    const std::string shape = "<shape type=\"rectangle\"><bsdf type=\"" + std::string(type) + "\"/></shape>";
    EXPECT_ERROR(read(shape), "s.xml:2:25: ") << type;
    EXPECT_TRUE(warns(approximated(shape), type)) << type;
  }
  for (const char* type : {"coating", "roughcoating"}) {
    const std::string shape =
        "<shape type=\"rectangle\"><bsdf type=\"" + std::string(type) + "\"><bsdf type=\"diffuse\"/></bsdf></shape>";
    EXPECT_ERROR(read(shape), "s.xml:2:25: ") << type;
    EXPECT_TRUE(warns(approximated(shape), type)) << type;
  }
  EXPECT_ERROR(read("<shape type=\"sphere\"><medium type=\"homogeneous\" name=\"interior\"/></shape>"),
               "there are no participating media");
  EXPECT_TRUE(warns(approximated("<shape type=\"sphere\"><medium type=\"homogeneous\" name=\"interior\"/></shape>"),
                    "taken as nothing"));
}

TEST(MitsubaBsdfs, BoundariesOfMediaAreNoSurfaceBeforeVersion2) {
  const auto shapes = [](const std::string& version, const std::string& more = "") {
    const std::string fog = "<shape type=\"cube\"><medium name=\"interior\" type=\"homogeneous\"/>" + more + "</shape>";
    return read(fog, version, true).objects[0].shapes.size();
  };
  EXPECT_EQ(shapes("0.6.0"), 0u);
  EXPECT_EQ(shapes("0.6.0", "<bsdf type=\"diffuse\"/>"), 1u);
  EXPECT_EQ(shapes("0.6.0", "<emitter type=\"area\"/>"), 1u);
  EXPECT_EQ(shapes("2.0.0"), 1u);
}

// Files whose bsdfs were rough once.
TEST(MitsubaBsdfs, RoughnessOfSmoothOnesHasNoEffectBeforeVersion2) {
  const std::string rough =
      "<float name=\"alpha\" value=\"0.1\"/><string name=\"distribution\" value=\"phong\"/></bsdf></shape>";
  for (const char* type : {"conductor", "dielectric", "plastic", "diffuse"}) {
    const std::string shape = "<shape type=\"sphere\"><bsdf type=\"" + std::string(type) + "\">" + rough;
    EXPECT_TRUE(warns(read(shape, "0.6.0"), "'alpha' has no effect, as in Mitsuba: only rough bsdfs have it")) << type;
    EXPECT_TRUE(warns(read(shape, "0.6.0"), "'distribution' has no effect")) << type;
    EXPECT_ERROR(read(shape, "3.0.0"), "unknown property 'alpha'");
  }
}

TEST(MitsubaBsdfs, TooBrightReflectancesAreScaledBeforeVersion2) {
  const auto reflectance = [](const std::string& name, const std::string& version) {
    return material_of<Diffuse>("<bsdf type=\"diffuse\"><rgb name=\"" + name + "\" value=\"2 1 .5\"/></bsdf>", version)
        .reflectance.constant;
  };
  expect_near(reflectance("reflectance", "0.6.0"), {0.99f, 0.495f, 0.2475f});
  expect_near(reflectance("diffuseReflectance", "0.6.0"), {0.99f, 0.495f, 0.2475f});
  expect_near(reflectance("reflectance", "3.0.0"), {1, 1, 0.5f});
  EXPECT_ERROR(reflectance("diffuseReflectance", "3.0.0"), "unknown property 'diffuseReflectance'");
  const std::string checks =
      "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><boolean name=\"ensureEnergyConservation\" value=\"true\"/>"
      "<texture type=\"checkerboard\" name=\"reflectance\"><rgb name=\"color0\" value=\"0.5\"/>"
      "<rgb name=\"color1\" value=\"1\"/></texture></bsdf></shape>";
  EXPECT_EQ(std::get<CheckerTexture>(read(checks, "0.6.0").textures.at(0)).odd, Rgb(1)) << "no brighter than 1";
}

TEST(MitsubaBsdfs, TheColoursOfATextureAreScaledTogether) {
  const auto diffuse = [](const std::string& texture, const std::string& more = "") {
    return "<shape type=\"rectangle\"><bsdf type=\"diffuse\">" + more + texture + "</bsdf></shape>";
  };
  const auto checks = [](const std::string& name) {
    return "<texture type=\"checkerboard\" name=\"" + name +
           "\"><rgb name=\"color0\" value=\"1.5\"/><rgb name=\"color1\" value=\"3\"/></texture>";
  };
  const auto read_checks = [](const Scene& scene) { return std::get<CheckerTexture>(scene.textures.at(0)); };
  const Scene scaled = read(diffuse(checks("reflectance")), "0.6.0");
  expect_near(read_checks(scaled).even, Rgb(0.495f));
  expect_near(read_checks(scaled).odd, Rgb(0.99f));
  EXPECT_TRUE(warns(scaled, "reaches 3, more than a surface can reflect: scaled to reach 0.99, as Mitsuba does"));
  EXPECT_TRUE(warns(read(diffuse(checks("reflectance"))), "clamped to 1"));
  const std::string kept = diffuse(checks("reflectance"), "<boolean name=\"ensureEnergyConservation\" value=\"false\"/>");
  EXPECT_ERROR(read(kept, "0.6.0"), "ensureEnergyConservation is false; --approximate takes scaled to reach 0.99");
  const Scene lamp = read("<shape type=\"rectangle\"><emitter type=\"area\">" + checks("radiance") + "</emitter></shape>");
  EXPECT_EQ(std::get<AreaLight>(lamp.lights.at(0)).radiance, Rgb(3)) << "a light may be brighter";
}

TEST(MitsubaBsdfs, ConstantTexturesAreLimitedLikeColours) {
  const std::string twice =
      "<texture type=\"scale\" name=\"NAME\"><rgb name=\"value\" value=\"0.8\"/>"
      "<float name=\"scale\" value=\"2\"/></texture>";
  const auto named = [&](const char* name) { return std::string(twice).replace(twice.find("NAME"), 4, name); };
  const Scene bright = read("<shape type=\"sphere\"><bsdf type=\"diffuse\">" + named("reflectance") + "</bsdf></shape>");
  EXPECT_EQ(std::get<Diffuse>(bright.materials.at(0)).reflectance.constant, Rgb(1));
  EXPECT_TRUE(warns(bright, "reaches 1.6, more than a surface can reflect: clamped to 1"));
  const std::string metal = "<bsdf type=\"conductor\">" + named("specularReflectance") + "</bsdf>";
  EXPECT_EQ(material_of<Conductor>(metal).tint, Rgb(1));
  expect_near(material_of<Conductor>(metal, "0.6.0").tint, Rgb(0.99f));
}

TEST(MitsubaBsdfs, TexturesMayBeSpectra) {
  const std::string lamp = R"(<shape type="sphere"><emitter type="area"><texture name="radiance" type="uniform">
    <float name="value" value="7"/></texture></emitter></shape>)";
  EXPECT_EQ(std::get<AreaLight>(read(lamp).lights.at(0)).radiance, Rgb(7));
  const auto grey = material_of<Diffuse>(R"(<bsdf type="diffuse"><texture name="reflectance" type="srgb">
    <rgb name="color" value="0.1 0.2 0.3"/></texture></bsdf>)");
  expect_near(grey.reflectance.constant, {0.1f, 0.2f, 0.3f});
}

TEST(MitsubaBsdfs, NestedTexturesMayBeNamedValue) {
  const std::string checks =
      "<texture type=\"checkerboard\" name=\"value\"><rgb name=\"color0\" value=\"0.5\"/>"
      "<rgb name=\"color1\" value=\"0.1\"/></texture>";
  const Scene scene = read("<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"scale\" name=\"reflectance\">" +
                               checks + "<float name=\"scale\" value=\"0.5\"/></texture></bsdf></shape>",
                           "0.6.0");
  expect_near(std::get<CheckerTexture>(scene.textures.at(0)).even, Rgb(0.25f));
}

TEST(MitsubaBsdfs, MetalsReflectAsTheirSpectraDo) {
  const auto straight_on = [](const char* name) {
    const auto metal =
        material_of<Conductor>(fmt::format(R"(<bsdf type="conductor"><string name="material" value="{}"/></bsdf>)", name));
    const Rgb e1 = metal.eta - 1.0f, e2 = metal.eta + 1.0f, k2 = metal.k * metal.k;
    return (e1 * e1 + k2) / (e2 * e2 + k2);
  };
  expect_near(straight_on("Cr"), {0.635f, 0.662f, 0.705f}, 2e-3f);
  expect_near(straight_on("Ni_palik"), {0.659f, 0.609f, 0.526f}, 2e-3f);
  expect_near(straight_on("TiN"), {0.611f, 0.462f, 0.233f}, 2e-3f);
  expect_near(straight_on("W"), {0.515f, 0.496f, 0.468f}, 2e-3f);
}

// What a conductor does not state is the named metal's before version 2, and copper's where none is named.
TEST(MitsubaBsdfs, MetalsMayStateOneOfTheirIndices) {
  const auto metal = [](const std::string& inside, const std::string& version) {
    return material_of<Conductor>("<bsdf type=\"conductor\">" + inside + "</bsdf>", version);
  };
  const std::string eta = "<spectrum name=\"eta\" value=\"0.2\"/>", gold = "<string name=\"material\" value=\"Au\"/>";
  EXPECT_EQ(metal(eta, "0.6.0").k, metal("", "0.6.0").k);
  EXPECT_EQ(metal(eta + gold, "0.6.0").k, metal(gold, "0.6.0").k);
  EXPECT_NEAR(metal(eta + gold, "0.6.0").eta.x, 0.2f, 1e-3f);
  EXPECT_EQ(metal(eta, "3.0.0").k, Rgb(1));
  EXPECT_ERROR(metal(eta + gold, "3.0.0"), "the one or the other");
}

TEST(MitsubaBsdfs, MasksAreKeptWithTheShape) {
  const auto mask = [](const std::string& opacity) {
    return "<bsdf type=\"mask\"><bsdf type=\"diffuse\"/>" + opacity + "</bsdf>";
  };
  const std::string checks = R"(<texture name="opacity" type="checkerboard">
    <rgb name="color0" value="1"/><rgb name="color1" value="0"/></texture>)";
  for (const char* shape : {"rectangle", "sphere"}) {
    const Scene scene = read("<shape type=\"" + std::string(shape) + "\">" + mask(checks) + "</shape>");
    EXPECT_TRUE(std::holds_alternative<CheckerTexture>(scene.textures.at(scene.objects[0].shapes.at(0).mask))) << shape;
  }
  const Scene half = read("<shape type=\"sphere\">" + mask("<float name=\"opacity\" value=\"0.25\"/>") + "</shape>");
  EXPECT_FLOAT_EQ(half.opacity_at({.t = 1, .uv = vec2(0.3f), .instance = 0, .primitive = 0}), 0.25f);
  EXPECT_EQ(read(rectangle).opacity_at({.t = 1, .uv = vec2(0.3f), .instance = 0, .primitive = 0}), 1);
  EXPECT_FALSE(read("<shape type=\"sphere\">" + mask("<float name=\"opacity\" value=\"1\"/>") + "</shape>").has_masks());
  EXPECT_TRUE(
      read("<shape type=\"sphere\">" + mask("<float name=\"opacity\" value=\"0\"/>") + "</shape>").objects[0].shapes.empty());
  const std::string blend =
      "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/><bsdf type=\"null\"/><bsdf "
      "type=\"diffuse\"/></bsdf>";
  EXPECT_FLOAT_EQ(read("<shape type=\"sphere\">" + blend + "</shape>").opacity_at({.t = 1, .instance = 0, .primitive = 0}),
                  0.25f);
}

TEST(MitsubaBsdfs, ColouredOpacitiesAreNumbersFromVersion2On) {
  const TestDirectory directory;
  const std::string header("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0", 18);
  directory.write("red.tga", header + std::string("\0\0\xff", 3));
  directory.write("grey.tga", header + "\xbc\xbc\xbc");
  const std::string red = R"(<rgb name="opacity" value="1,0,0"/>)",
                    image = R"(<texture name="opacity" type="bitmap"><string name="filename" value="red.tga"/></texture>)";
  const auto masked = [&](const std::string& opacity, const char* version, bool approximate) {
    return load_scene(
        directory.write("s.xml", scene_text("<shape type=\"rectangle\"><bsdf type=\"mask\"><bsdf type=\"diffuse\"/>" + opacity +
                                                "</bsdf></shape>",
                                            version)),
        {}, {.approximate = approximate});
  };
  const auto share = [](const Scene& scene) {
    return scene.opacity_at({.t = 1, .uv = vec2(0.3f), .instance = 0, .primitive = 0});
  };
  EXPECT_NEAR(share(masked(image, "3.0.0", false)), luminance(Rgb(1, 0, 0)), 1e-5f) << "an image's luminance";
  EXPECT_NEAR(share(masked(red, "3.0.0", false)), 1.0f / 3, 1e-5f) << "the mean of a colour";
  for (const std::string& opacity : {red, image}) {
    EXPECT_ERROR(masked(opacity, "0.6.0", false), "an opacity that differs between colours");
    EXPECT_TRUE(warns(masked(opacity, "0.6.0", true), "what passes keeps its colour"));
  }
  const std::string grey = R"(<texture name="opacity" type="bitmap"><string name="filename" value="grey.tga"/></texture>)";
  EXPECT_EQ(share(masked(grey, "0.6.0", false)), share(masked(grey, "3.0.0", false)));
}

TEST(MitsubaBsdfs, LightsMayLetRaysThrough) {
  const auto opacity = [](const std::string& bsdf) {
    const Scene scene = read("<shape type=\"sphere\"><emitter type=\"area\"/>" + bsdf + "</shape>");
    EXPECT_EQ(scene.objects[0].shapes.at(0).first_light, 0u);
    return scene.opacity_at({.t = 1, .uv = vec2(0.3f), .instance = 0, .primitive = 0});
  };
  const auto mask = [](const char* share, const char* of) {
    return fmt::format(R"(<bsdf type="mask"><float name="opacity" value="{}"/><bsdf type="{}"/></bsdf>)", share, of);
  };
  EXPECT_EQ(opacity("<bsdf type=\"null\"/>"), 0);
  EXPECT_EQ(opacity(mask("0", "diffuse")), 0);
  EXPECT_EQ(opacity(mask("0.5", "null")), 0);
  EXPECT_EQ(opacity(mask("0.25", "diffuse")), 0.25f);
  EXPECT_EQ(opacity("<bsdf type=\"diffuse\"/>"), 1);
}

TEST(MitsubaBsdfs, MasksTakeTheAlphaOfAnImage) {
  const TestDirectory directory;
  const std::string header("\0\0\2\0\0\0\0\0\0\0\0\0\2\0\1\0\x20\x28", 18), texels("\0\0\0\xff\xff\xff\xff\0", 8);
  directory.write("leaf.tga", header + texels);  // black beside white that is transparent
  const auto masked = [&](const std::string& inside) {
    return load_scene(
        directory.write("s.xml", scene_text("<shape type=\"rectangle\"><bsdf type=\"mask\"><bsdf type=\"diffuse\"/><texture "
                                            "name=\"opacity\" type=\"bitmap\"><string name=\"filename\" value=\"leaf.tga\"/>" +
                                            inside + "</texture></bsdf></shape>")),
        {}, {.approximate = true});
  };
  const auto is_left = [](const Scene& scene) {
    const Texture& mask = scene.textures.at(scene.objects[0].shapes.at(0).mask);
    return evaluate(mask, {0.25f, 0.5f}).x == 1 && evaluate(mask, {0.75f, 0.5f}).x == 0;
  };
  EXPECT_TRUE(is_left(masked("")));
  EXPECT_TRUE(warns(masked(""), "Mitsuba takes the colours of 'leaf.tga'"));
  const Scene by_channel = masked("<string name=\"channel\" value=\"a\"/>");
  EXPECT_TRUE(is_left(by_channel));
  EXPECT_FALSE(warns(by_channel, "Mitsuba takes the colours"));
}

TEST(MitsubaColours, AreLinearRgb) {
  const auto reflectance = [](const std::string& colour, const std::string& version = "3.0.0") {
    return material_of<Diffuse>("<bsdf type=\"diffuse\">" + colour + "</bsdf>", version).reflectance.constant;
  };
  expect_near(reflectance("<rgb name=\"reflectance\" value=\"0.1 0.2, 0.3\"/>"), {0.1f, 0.2f, 0.3f});
  expect_near(reflectance("<srgb name=\"reflectance\" value=\"#ff8000\"/>"), {1, 0.21586f, 0});
  expect_near(reflectance("<spectrum name=\"reflectance\" value=\"400:0.4, 700:0.4\"/>"), Rgb(0.4f), 1e-3f);
  const Rgb pink = reflectance("<spectrum name=\"reflectance\" value=\"400:0.4, 700:0.4\"/>", "0.5.0");
  EXPECT_NEAR(luminance(pink), 0.4f, 2e-3) << "before version 2, under light of equal energy";
  EXPECT_GT(pink.x, 1.2f * pink.y);
  EXPECT_EQ(light_of<PointLight>("<emitter type=\"point\"><spectrum name=\"intensity\" value=\"3\"/></emitter>").intensity,
            Rgb(3));
  const Rgb warm =
      light_of<PointLight>("<emitter type=\"point\"><blackbody name=\"intensity\" temperature=\"3000K\"/></emitter>").intensity;
  EXPECT_GT(warm.x, warm.z);
  EXPECT_ERROR(reflectance("<spectrum name=\"reflectance\" value=\"500:1, 400:1\"/>"), "wavelengths must increase");
  EXPECT_ERROR(reflectance("<rgb name=\"reflectance\" value=\"-1\"/>"), "has the component -1; expected 0 to 1");
  EXPECT_ERROR(reflectance("<srgb name=\"reflectance\" value=\"#ff80\"/>"), "expected #rrggbb");
  const std::string hexadecimal = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"#336699\"/></bsdf>";
  expect_near(material_of<Diffuse>(hexadecimal, "0.6.0").reflectance.constant, {0.2f, 0.4f, 0.6f});
  for (const auto& [version, ideal] : {std::pair("0.6.0", false), std::pair("2.0.0", true), std::pair("3.0.0", true)})
    EXPECT_EQ(material_of<Conductor>("<bsdf type=\"conductor\"/>", version).ideal, ideal) << version;
}

Rgb texture_at(const Scene& scene, const vec2& mitsuba_uv) { return evaluate(scene.textures.at(0), mitsuba_uv); }

TEST(MitsubaTextures, AreMappedAsMitsubaMapsThem) {
  const TestDirectory directory;
  const std::uint8_t black_over_white[] = {0, 0, 0, 255, 255, 255};
  const auto png = encode_png(black_over_white, {1, 2});
  directory.write("t.png", std::string(png.begin(), png.end()));
  const auto textured = [&](const std::string& inside) {
    return load_scene(
        directory.write("s.xml", scene_text("<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture name=\"reflectance\" "
                                            "type=\"bitmap\"><string name=\"filename\" value=\"t.png\"/>" +
                                            inside + "</texture></bsdf></shape>")));
  };
  const Scene plain = textured("");
  expect_near(texture_at(plain, {0.5f, 0.25f}), Rgb(0));
  expect_near(texture_at(plain, {0.5f, 0.75f}), Rgb(1));
  const Scene mirrored = textured("<string name=\"wrap_mode\" value=\"mirror\"/>");
  expect_near(texture_at(mirrored, {0.5f, 0.25f}), Rgb(0));
  expect_near(texture_at(mirrored, {0.5f, 1.25f}), Rgb(1));
  expect_near(texture_at(mirrored, {0.5f, 1.75f}), Rgb(0));
  const Scene nearest = textured("<string name=\"filter_type\" value=\"nearest\"/>");
  expect_near(texture_at(nearest, {0.5f, 0.45f}), Rgb(0));
  expect_near(texture_at(nearest, {0.5f, 0.55f}), Rgb(1));
  EXPECT_FALSE(warns(nearest, "interpolated"));
  const Scene moved = textured("<transform name=\"to_uv\"><translate y=\"0.5\"/></transform>");
  expect_near(texture_at(moved, {0.5f, 0.25f}), Rgb(1));
  EXPECT_ERROR(textured("<string name=\"wrap_mode\" value=\"one\"/>"), "'wrap_mode' is 'one'; expected repeat, mirror");

  const Scene checks = read(R"(<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">
    <transform name="to_uv"><scale x="5" y="5"/></transform></texture></bsdf></shape>)");
  expect_near(texture_at(checks, {0.05f, 0.05f}), Rgb(0.4f));
  expect_near(texture_at(checks, {0.15f, 0.05f}), Rgb(0.2f));
  expect_near(texture_at(checks, {0.15f, 0.15f}), Rgb(0.4f));
}

}  // namespace
}  // namespace etendue::mitsuba_test
