// Materials of pbrt without an exact equal: which of ours they become, and how bright.
#include "framework/io/spectra.h"
#include "framework/materials/fresnel.h"
#include "tests/unit/io_pbrt_helpers.h"

namespace etendue {
namespace {

// The base under a coat, seen straight on under even light: light comes in through the coat from everywhere and goes out
// straight.
float base_brightness(const Plastic& p) {
  const float eta = p.coat.eta(), albedo = p.reflectance.constant.x, straight = square((eta - 1) / (eta + 1));
  return albedo / (eta * eta * (1 - albedo * p.coat.internal_reflectance())) * (1 - straight) * (1 - fresnel_average(eta));
}

TEST(PbrtNearest, CoatsReflectTheirShareAndKeepTheBaseAsBright) {
  const Plastic plastic = material_of<Plastic>("Material \"plastic\" \"rgb Kd\" [.25 .25 .25] \"rgb Ks\" [.7 .7 .7]");
  EXPECT_NEAR(fresnel_average(plastic.coat.eta()), 0.7f * Coat(1.5f).internal_reflectance(), 1e-4f)
      << "pbrt-v3 sees it from within";
  EXPECT_NEAR(base_brightness(plastic), 0.25f, 1e-5f);
  const Plastic substrate = material_of<Plastic>(
      "Material \"substrate\" \"rgb Kd\" [.1 .1 .1] \"rgb Ks\" [.3 .3 .3] \"float uroughness\" .2 \"float "
      "vroughness\" .2 \"bool remaproughness\" false");
  EXPECT_NEAR(square((substrate.coat.eta() - 1) / (substrate.coat.eta() + 1)), 0.3f, 1e-5f);
  EXPECT_NEAR(base_brightness(substrate), 0.1f, 1e-5f);
  EXPECT_FLOAT_EQ(substrate.alpha, 0.2f);
  EXPECT_EQ(material_of<Diffuse>("Material \"plastic\" \"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [0 0 0]").reflectance.constant,
            Rgb(0.1f, 0.2f, 0.3f));
}

TEST(PbrtNearest, UberIsWhicheverOfItsLobesItHas) {
  const std::string uber = "Material \"uber\" ";
  EXPECT_EQ(material_of<Diffuse>(uber + "\"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [0 0 0]").reflectance.constant,
            Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_GT(material_of<Plastic>(uber).alpha, 0.1f);
  const Plastic smooth = material_of<Plastic>(uber + "\"rgb Ks\" [0 0 0] \"rgb Kr\" [1 1 1] \"float index\" 1.7");
  EXPECT_EQ(smooth.alpha, 0);
  EXPECT_NEAR(smooth.coat.eta(), 1.7f, 1e-4f);
  EXPECT_EQ(material_of<Diffuse>(uber + "\"float index\" 1 \"rgb Kr\" [1 1 1]").reflectance.constant, Rgb(0.25f));
  EXPECT_ERROR(material_of<Plastic>(uber + "\"float index\" 0.9"), "expected 1 to 10");
  const Dielectric glass =
      material_of<Dielectric>(uber + "\"rgb Kd\" [0 0 0] \"rgb Ks\" [0 0 0] \"rgb Kr\" [1 1 1] \"rgb Kt\" [.5 1 1]");
  EXPECT_EQ(glass.transmit_tint, Rgb(0.5f, 1, 1));
  EXPECT_ERROR(material_of<Dielectric>(uber + "\"rgb Kt\" [.5 1 1]"), "'Kt' beside Kd or Ks");
  const Hit hit{.t = 1, .uv = vec2(0.25f), .instance = 0, .primitive = 0};
  EXPECT_EQ(world(uber + "\"rgb opacity\" [.5 .5 .5] " + triangle).opacity_at(hit), 0.5f);
  EXPECT_TRUE(world(uber + "\"float opacity\" 0 " + triangle).objects[0].shapes.empty());
  EXPECT_ERROR(world(uber + "\"rgb opacity\" [.25 .5 .75]"), "'opacity' of a colour: light of all colours passes alike");
}

TEST(PbrtNearest, MixturesOfDiffuseSurfacesAreExact) {
  const std::string parts =
      "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [1 0 0] MakeNamedMaterial \"b\" \"string type\" \"matte\" "
      "\"rgb "
      "Kd\" [0 1 0] MakeNamedMaterial \"m\" \"string type\" \"mirror\" ";
  expect_near(
      material_of<Diffuse>(parts + "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb "
                                   "amount\" [.25 .25 .25]")
          .reflectance.constant,
      {0.25f, 0.75f, 0});
  expect_near(material_of<Diffuse>(parts + "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25")
                  .reflectance.constant,
              {0.75f, 0.25f, 0});
  const std::string mirrors =
      "MakeNamedMaterial \"c\" \"string type\" \"mirror\" \"rgb Kr\" [1 0 0] MakeNamedMaterial \"d\" \"string "
      "type\" \"mirror\" \"rgb Kr\" [0 1 0] ";
  expect_near(material_of<Conductor>(mirrors + "Material \"mix\" \"string materials\" [\"c\" \"d\"] \"float amount\" .25").tint,
              {0.75f, 0.25f, 0});
  expect_near(
      material_of<Conductor>(mirrors + "Material \"mix\" \"string namedmaterial1\" \"c\" \"string namedmaterial2\" \"d\" "
                                       "\"rgb amount\" [.25 1 0]")
          .tint,
      {0.25f, 0, 0});
  const std::string other = parts + "Material \"mix\" \"string materials\" [\"a\" \"m\"] \"float amount\" ";
  EXPECT_TRUE(material_of<Conductor>(other + "1").ideal) << "wholly the second";
  EXPECT_ERROR(world(other + ".7"), "material \"mix\" is not supported but of surfaces that are diffuse");
  EXPECT_TRUE(approximate_material_of<Conductor>(other + ".7").ideal);
  EXPECT_ERROR(world(parts + "Material \"mix\" \"string materials\" [\"a\" \"n\"]"), "unknown named material 'n'");
}

TEST(PbrtNearest, RoughDiffuseSurfacesKeepTheirAlbedo) {
  EXPECT_EQ(material_of<Diffuse>("Material \"matte\" \"float sigma\" 0 \"float Kd\" .5").reflectance.constant, Rgb(0.5f));
  // The mean of A + B max(0, cos) sin tan over both directions, by quadrature.
  const double sigma = 20 * M_PI / 180, s2 = sigma * sigma, a = 1 - s2 / (2 * (s2 + 0.33)), b = 0.45 * s2 / (s2 + 0.09);
  double mean = 0;
  constexpr int n = 200;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = (i + 0.5) * M_PI / 2 / n, y = (j + 0.5) * M_PI / 2 / n;
      mean += (a + b / M_PI * std::sin(std::max(x, y)) * std::tan(std::min(x, y))) * std::sin(2 * x) * std::sin(2 * y);
    }
  mean *= square(static_cast<float>(M_PI / 2 / n));
  const Diffuse rough = approximate_material_of<Diffuse>("Material \"matte\" \"float sigma\" 20 \"float Kd\" .5");
  EXPECT_NEAR(rough.reflectance.constant.x, 0.5 * mean, 1e-4);
}

TEST(PbrtNearest, ThinLayeredAndTransmittingSurfaces) {
  const auto pane = material_of<Dielectric>("Material \"thindielectric\" \"float eta\" 1.4");
  EXPECT_TRUE(pane.thin);
  EXPECT_EQ(pane.eta, 1.4f);
  const Conductor coated = approximate_material_of<Conductor>(
      "Material \"coatedconductor\" \"rgb reflectance\" [.9 .5 .1] \"float interface.roughness\" 0 \"float "
      "conductor.roughness\" .04");
  EXPECT_FLOAT_EQ(coated.alpha.x, 0.2f);
  const Rgb r = (coated.k * coated.k) / (4.0f + coated.k * coated.k), base(0.9f, 0.5f, 0.1f);
  expect_near(r, 0.04f + 0.96f * 0.96f * base / (1.0f - 0.04f * base), 1e-4f);
  const auto leaf =
      material_of<DiffuseTransmission>("Material \"diffusetransmission\" \"rgb reflectance\" [.1 .2 .25] \"float scale\" 2");
  expect_near(leaf.reflectance.constant, {0.2f, 0.4f, 0.5f});
  expect_near(leaf.transmittance.constant, Rgb(0.5f));
  const std::string bright = "Material \"diffusetransmission\" \"rgb reflectance\" [.9 .9 .9] \"rgb transmittance\" [.6 .3 .3]";
  EXPECT_ERROR(world(bright + triangle), "more than all light");
  expect_near(approximate_material_of<DiffuseTransmission>(bright).transmittance.constant, {0.4f, 0.2f, 0.2f});
  const auto paper = material_of<DiffuseTransmission>(
      "Material \"translucent\" \"rgb Kd\" [.8 .4 .2] \"rgb Ks\" [0 0 0] "
      "\"rgb transmit\" [.25 .25 .25]");
  expect_near(paper.reflectance.constant, {0.4f, 0.2f, 0.1f});
  expect_near(paper.transmittance.constant, {0.2f, 0.1f, 0.05f});
  const auto all = material_of<DiffuseTransmission>(
      "Material \"translucent\" \"rgb Kd\" [.3 .3 .3] \"rgb Ks\" [0 0 0] "
      "\"rgb reflect\" [1 1 1] \"rgb transmit\" [1 1 1]");
  expect_near(all.transmittance.constant, Rgb(0.3f));
  EXPECT_ERROR(world("Material \"translucent\"" + triangle), "'Ks' of material");
  EXPECT_EQ(material_of<Dielectric>("Material \"dielectric\" \"float eta\" .75").eta, 0.75f) << "as of air in water";
  EXPECT_EQ(material_of<Dielectric>("Material \"dielectric\" \"float eta\" 1 \"float roughness\" .3").alpha, 0);
}

TEST(PbrtNearest, MaterialsThatAreFarFromOursHaveTheirAlbedo) {
  const Plastic skin = approximate_material_of<Plastic>("Material \"subsurface\" \"string name\" \"Skin1\"");
  EXPECT_GT(skin.reflectance.constant.x, 1.2f * skin.reflectance.constant.z);
  EXPECT_FLOAT_EQ(skin.coat.eta(), 1.33f) << "of skin, not of glass";
  const std::string layered = "Material \"coatedconductor\" ";
  expect_near(approximate_material_of<Conductor>(layered + "\"spectrum interface.eta\" \"glass-BK7\"").k,
              approximate_material_of<Conductor>(layered + "\"float interface.eta\" 1.5168").k);
  EXPECT_FLOAT_EQ(approximate_material_of<Plastic>("Material \"kdsubsurface\"").coat.eta(), 1.33f);
  for (const char* far : {"hair", "measured", "fourier"}) {
    EXPECT_ERROR(world("Material \"" + std::string(far) + "\" \"string filename\" \"x\""),
                 "is not supported; --approximate takes a diffuse");
    approximate_material_of<Diffuse>("Material \"" + std::string(far) + "\"");
  }
  EXPECT_TRUE(
      warns(approximated("Texture \"x\" \"float\" \"checkerboard\" Material \"matte\" \"texture bumpmap\" \"x\"" + triangle),
            "checks as relief are flat"));
  EXPECT_TRUE(warns(approximated("Material \"matte\" \"rgb Kd\" [.1 1.5 0]"), "a reflectance above 1: taken as 1"));
}

TEST(PbrtNearest, TexturesAboveOneAreTold) {
  const std::string matte = " Material \"matte\" \"texture Kd\" \"t\" " + triangle;
  const std::string constant = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [2 .5 0]" + matte;
  EXPECT_ERROR(world(constant), "a reflectance above 1; --approximate takes 1");
  const Scene scene = approximated(constant);
  EXPECT_EQ(std::get<Diffuse>(scene.materials.at(0)).reflectance.constant, Rgb(1, 0.5f, 0));
  const auto dots = [&](const char* inside) {
    return world("Texture \"t\" \"spectrum\" \"dots\" \"float uscale\" 20 \"float vscale\" 20 \"rgb inside\" " +
                 std::string(inside) + matte);
  };
  EXPECT_TRUE(warns(dots("[3 1 1]"), "texture 't' reaches beyond 1, more than a surface can reflect: clamped to 1"));
  EXPECT_FALSE(warns(dots("[1 1 1]"), "reaches beyond 1"));
}

TEST(PbrtNearest, BoundariesOfMediaAreNotSeen) {
  for (const char* name : {"", "none", "interface"})
    EXPECT_TRUE(world("Material \"" + std::string(name) + "\" " + triangle + "Shape \"sphere\"").objects[0].shapes.empty());
  const Scene dark = world("Material \"interface\" AreaLightSource \"diffuse\" " + triangle);
  EXPECT_TRUE(dark.objects[0].shapes.empty() && dark.lights.empty());
  EXPECT_TRUE(warns(dark, "does not shine"));
  const Scene lamp =
      parse_pbrt("Film \"image\"\nWorldBegin Material \"none\" AreaLightSource \"diffuse\" " + triangle, "s.pbrt");
  EXPECT_EQ(lamp.lights.size(), 1u) << "of version 3";
  EXPECT_EQ(lamp.opacity_at({.t = 1, .uv = vec2(0.3f), .instance = 0, .primitive = 0}), 0);
  EXPECT_TRUE(world("Shape \"sphere\" \"float alpha\" 0").objects[0].shapes.empty());
}

}  // namespace
}  // namespace etendue
