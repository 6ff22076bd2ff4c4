// Scenes written as pbrt: read back they are the same scenes, and written again the same files; what pbrt cannot say is told.
#include "framework/io/load_scene.h"
#include "framework/io/pbrt/pbrt.h"
#include "framework/io/pbrt/write.h"
#include "framework/scene/builder.h"
#include "tests/render_scene.h"
#include "tests/unit/io_helpers.h"

#include <map>

namespace etendue {
namespace {

using Files = std::map<std::string, std::string>;

class PbrtWrite : public ::testing::Test {
 protected:
  struct Written {
    Scene scene;  // as it is read back
    std::string text;
    Files files;
    std::vector<std::string> warnings;
  };
  Written written(const Scene& scene) {
    Written result;
    PbrtText text = write_pbrt(scene, "s-files", [&](const std::string& name, std::string_view bytes) {
      directory_.write(name, std::string(bytes));
      result.files.emplace(name, bytes);
    });
    result.scene = read_pbrt(directory_.write("s.pbrt", text.text));
    result.text = std::move(text.text);
    result.warnings = std::move(text.warnings);
    return result;
  }
  // Writes, and writes again what was read.
  Written twice_written(const Scene& scene) {
    Written first = written(scene);
    const Written second = written(first.scene);
    EXPECT_EQ(first.text, second.text);
    EXPECT_TRUE(first.files == second.files);
    return first;
  }
  static std::uint64_t image_of(const Scene& scene) {
    return testing::render(scene, "path", {.params = {}, .iterations = 1, .resolution = {16, 16}}).hash;
  }
  static std::string all(const std::vector<std::string>& warnings) {
    std::string text;
    for (const std::string& warning : warnings) text += warning + "\n";
    return text;
  }
  TestDirectory directory_;
};

// The others have infinite planes, a cylinder with caps, or metal that pbrt lacks; or a sun whose direction is not unit to the
// last bit, as pbrt's are.
TEST_F(PbrtWrite, BuiltInScenesRenderTheSameBits) {
  const std::string others[] = {"polygon-light",      "sphere-light",   "disc-light", "white-furnace",
                                "glossy-cornell-box", "glossy-furnace", "glossy-lamp"};
  const std::string suns[] = {"exterior", "stadium", "far-kerb"};
  const auto is_one_of = [](const auto& names, const std::string& name) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
  };
  for (const BuiltinScene& entry : builtin_scenes()) {
    if (entry.name == std::string("mesh-large")) continue;  // mesh again
    SCOPED_TRACE(entry.name);
    const Scene scene = entry.make();
    const Written again = twice_written(scene);
    if (is_one_of(others, entry.name)) {
      EXPECT_NE(all(again.warnings).find("pbrt has none"), std::string::npos);
    } else if (!is_one_of(suns, entry.name)) {
      EXPECT_EQ(image_of(scene), image_of(again.scene));
    }
    if (scene.closed_form) {
      EXPECT_NE(all(again.warnings).find(scene.closed_form->source), std::string::npos);
    }
  }
}

TEST_F(PbrtWrite, PlanesAndCapsRenderNearlyTheSame) {
  for (const char* name : {"builtin:polygon-light", "builtin:white-furnace"}) {
    const Scene scene = load_scene(name, {});
    const auto mean = [](const Scene& s) {
      dvec3 sum(0);
      const Image image = testing::render(s, "path", {.params = {}, .iterations = 32, .resolution = {24, 24}}).image;
      for (const dvec3& pixel : image.pixels) sum += pixel / static_cast<double>(image.pixels.size());
      return sum.x;
    };
    EXPECT_NEAR(mean(written(scene).scene) / mean(scene), 1, 0.02) << name;
  }
}

// Everything that the reader makes of a file, but for images: each is the same to the bit.
TEST_F(PbrtWrite, WhatWasReadIsWrittenExactly) {
  const std::string text = R"(
    LookAt 3 4 1.5  .5 .5 0  0 0 1
    Camera "perspective" "float fov" 45.7 "float lensradius" 0.1 "float focaldistance" 4.3
    Film "rgb" "integer xresolution" 17 "integer yresolution" 12
    Integrator "path" "integer maxdepth" 7
    WorldBegin
    LightSource "point" "point3 from" [0.1 0.2 3.3] "rgb I" [1 2 3]
    LightSource "spot" "point3 from" [1 2 3] "point3 to" [0.3 0.7 -0.1] "float coneangle" 23.4 "float conedeltaangle" 3.7
    LightSource "distant" "point3 to" [0.3 -0.7 -0.1] "rgb L" [0.1 0.1 0.1]
    LightSource "infinite" "rgb L" [0.01 0.02 0.03]
    Texture "checks" "spectrum" "checkerboard" "rgb tex1" [0.1 0.2 0.3] "float uscale" 7 "float vdelta" 0.3
    MakeNamedMaterial "checked" "string type" "diffuse" "texture reflectance" "checks"
    MakeNamedMaterial "brushed" "string type" "conductor" "spectrum eta" "metal-Al-eta" "spectrum k" "metal-Al-k"
      "float uroughness" 0.1 "float vroughness" 0.3
    ObjectBegin "twig"
      NamedMaterial "checked"
      Rotate 30 1 2 3
      Shape "sphere" "float radius" 0.3
      Shape "cylinder" "float radius" 0.1
      Scale 1 2 1
      ReverseOrientation
      Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "normal3 N" [0 0 1 0.1 0.2 1 0 0.3 0.9] "point2 uv" [0 0 1 0 0 1]
    ObjectEnd
    AttributeBegin
      Rotate 20 0 0 1
      ObjectInstance "twig"
      Translate 0 0 1
      ObjectInstance "twig"
    AttributeEnd
    AttributeBegin
      AreaLightSource "diffuse" "rgb L" [3 2 1] "bool twosided" true
      Rotate 33 1 2 0.5
      Shape "disk" "float radius" 0.37 "float innerradius" 0.1
      Translate 1 1 1
      Shape "cylinder" "float radius" 0.2 "float zmin" -0.3 "float zmax" 0.7
    AttributeEnd
    Material "glass" "rgb Kr" [0.5 0.6 0.7] "float eta" 1.3 "float roughness" 0.2
    Shape "sphere" "float radius" 1
    Material "mirror" "rgb Kr" [0.5 0.6 0.7]
    ReverseOrientation
    Shape "disk" "float radius" 2
    Material "coateddiffuse" "rgb reflectance" [0.5 0.6 0.7] "float eta" 1.3 "float roughness" 0.2
    Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "normal3 N" [0 0 1 0.1 0.2 1 0 0.3 0.9]
    Material "thindielectric" "float eta" 1.4
    Shape "disk" "float radius" 1.3
    Material "diffusetransmission" "rgb reflectance" [0.1 0.2 0.3] "rgb transmittance" [0.3 0.2 0.1]
    Shape "disk" "float radius" 0.7 "float height" 0.3
    NamedMaterial "brushed"
    Shape "sphere" "float radius" 0.4)";
  const Scene scene = parse_pbrt(text, "s.pbrt");
  const Written again = twice_written(scene);
  EXPECT_EQ(again.scene.content_hash(), written(again.scene).scene.content_hash());
  EXPECT_EQ(again.scene.lights.size(), scene.lights.size());
  EXPECT_EQ(again.scene.instances.size(), scene.instances.size());
  EXPECT_EQ(again.scene.max_depth, 7);
  EXPECT_EQ(image_of(again.scene), image_of(scene));
  EXPECT_EQ(again.files.size(), 2u);
}

TEST_F(PbrtWrite, CamerasAndFarScenesKeepTheirPlace) {
  for (const char* camera :
       {R"(Camera "orthographic" "float screenwindow" [-3 3 -2 2])", R"(Camera "perspective" "float fov" 12)"}) {
    const Scene scene = parse_pbrt(std::string("LookAt 5000001 4 2 5000000 0 0 0 0 1\n"
                                               "Film \"rgb\" \"integer xresolution\" 30 \"integer yresolution\" 20\n") +
                                       camera +
                                       "\nWorldBegin LightSource \"infinite\" Translate 5000000 0 0\n"
                                       "Shape \"sphere\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]",
                                   "s.pbrt");
    // The width of a parallel view is the length of an axis, which rounds anew each time.
    const Written again = scene.camera.is_parallel() ? written(scene) : twice_written(scene);
    EXPECT_NE(again.text.find("5000000"), std::string::npos);
    EXPECT_EQ(again.scene.content_hash(), scene.content_hash());
    if (!scene.camera.is_parallel()) {
      EXPECT_EQ(again.scene.hash(), scene.hash());
    }
    EXPECT_NEAR(again.scene.camera.half_width, scene.camera.half_width, 1e-6f);
  }
}

TEST_F(PbrtWrite, TexturesKeepTheirTexels) {
  Scene scene = load_scene("builtin:cornell-box", {});
  const auto add = [&](std::vector<Rgb> texels, const vec2& scale) {
    TexturedRgb colour;
    colour.texture = static_cast<std::uint32_t>(scene.textures.size());
    scene.textures.emplace_back(ImageTexture{.size = {2, 1}, .texels = std::move(texels), .uv_scale = scale, .gain = 0.5f});
    return colour;
  };
  std::get<Diffuse>(scene.materials[0]).reflectance = add({Rgb(1), Rgb(0)}, {1, 2});
  std::get<Diffuse>(scene.materials[1]).reflectance = add({Rgb(0.123f), Rgb(0.5f, 0.1f, 0)}, {3, 1});
  scene.lights.insert(scene.lights.begin(),
                      EnvironmentLight{.size = {2, 2}, .texels = {Rgb(1), Rgb(20), Rgb(0.1f), Rgb(0)}, .light_to_world = {}});
  for (Shape& shape : scene.objects[0].shapes) {
    shape.uses_uvs = uses_uvs(scene.materials[shape.material]);
    if (shape.first_light != no_id) ++shape.first_light;
  }
  const Written again = twice_written(scene);
  EXPECT_TRUE(again.files.contains("s-files/texture-0.png"));  // of bytes alone
  EXPECT_TRUE(again.files.contains("s-files/texture-1.exr"));
  EXPECT_TRUE(again.files.contains("s-files/environment-0.exr"));
  ASSERT_EQ(again.scene.textures.size(), 2u);
  EXPECT_EQ(std::get<ImageTexture>(again.scene.textures[0]).texels, std::get<ImageTexture>(scene.textures[0]).texels);
  EXPECT_EQ(image_of(again.scene), image_of(scene));
  EXPECT_NE(all(again.warnings).find("mapname"), std::string::npos);
}

TEST_F(PbrtWrite, MasksFiltersAndCropsAreKept) {
  Scene scene = load_scene("builtin:cornell-box", {});
  scene.textures = {ImageTexture{.size = {1, 1}, .texels = {Rgb(0.3f)}},
                    ImageTexture{.size = {2, 1}, .texels = {Rgb(0.1f), Rgb(0.9f)}, .gain = 1.5f},
                    CheckerTexture{.even = Rgb(1), .odd = Rgb(0.25f), .uv_scale = {3, 2}, .uv_offset = {0.1f, 0}}};
  std::uint32_t mask = 0;
  for (Shape& shape : scene.objects[0].shapes)
    if (shape.first_light == no_id && mask < 3) shape.mask = mask++;
  scene.crop = std::array<float, 4>{0.25f, 1, 0, 0.5f};
  for (const FilterShape& filter :
       {FilterShape{.radius = {1, 0.5f}}, FilterShape{.kind = FilterKind::gaussian, .radius = vec2(1.7f), .sigma = 0.37f},
        FilterShape{.kind = FilterKind::mitchell, .radius = vec2(2), .b = 0.1f, .c = 0.7f},
        FilterShape{.kind = FilterKind::sinc, .radius = vec2(3), .tau = 2.5f},
        FilterShape{.kind = FilterKind::triangle, .radius = {2, 1}}}) {
    scene.filter = make_pixel_filter(filter);
    const Written again = twice_written(scene);
    ASSERT_TRUE(again.scene.filter);
    EXPECT_EQ(again.scene.filter->shape(), filter) << filter.text();
    EXPECT_EQ(again.scene.crop, scene.crop);
    EXPECT_TRUE(again.scene.has_masks());
    EXPECT_EQ(image_of(again.scene), image_of(scene)) << filter.text();
  }
}

TEST_F(PbrtWrite, WhatPbrtCannotSayIsTold) {
  SceneBuilder builder("s");
  builder.camera({0, 0, 5}, {0, 0, 0}, 40, {16, 16});
  builder.light(SpotLight{.position = {0, 3, 0}, .direction = {0, -1, 0}, .fade = SpotFade::linear});
  builder.light(SpotLight{.position = {1, 3, 0}, .direction = {0, -1, 0}, .fade = SpotFade::quartic});
  const Material materials[] = {Conductor{.tint = Rgb(0.5f), .ideal = true, .alpha = vec2(0.3f)},
                                Conductor{.eta = Rgb(0.2f), .k = Rgb(3), .tint = Rgb(0.5f)},
                                Dielectric{.eta = 1.5f, .transmit_tint = Rgb(0.5f)},
                                Dielectric{.eta = 1.5f, .transmit_tint = Rgb(0.5f), .thin = true},
                                Dielectric{.eta = 12, .alpha = 1.5f},
                                Plastic{.alpha = 0.2f, .distribution = NormalDistribution::beckmann}};
  for (const Material& material : materials) builder.quadric(Sphere{vec3(0), 1}, builder.material(material));
  builder.mesh(quad({-1, -1, 1}, {-1, 2, 1}, {1, 2, 1}, {1, -1, 1}), builder.material(Diffuse{}));
  Scene scene = builder.finish();
  scene.textures = {ImageTexture{.size = {1, 1}, .texels = {Rgb(1)}, .wrap_u = Wrap::mirror}};
  std::get<Diffuse>(scene.materials.back()).reflectance.texture = 0;
  scene.reliefs.emplace_back();
  scene.lights.push_back(AreaLight{.texture = 0});
  const Written again = written(scene);
  for (const char* told :
       {"fade evenly", "fade as in pbrt-v3", "tinted, or the same at all angles", "tinted glass", "tinted panes",
        "an index of 12", "a roughness of 1.5", "Beckmann", "are mirrored", "bump and normal maps", "images on lights"})
    EXPECT_NE(all(again.warnings).find(told), std::string::npos) << told;
}

}  // namespace
}  // namespace etendue
