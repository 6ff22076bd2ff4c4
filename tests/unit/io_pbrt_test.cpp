// The language: lexing, parameters, transforms, blocks, options and files.
#include "framework/io/load_scene.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <fmt/format.h>

namespace etendue {
namespace {

// A small scene with most of the language, for damage.
const std::string everything = R"(# everything
Scale -1 1 1
LookAt 0 -4 0.5  0 0 0  0 0 1
Camera "perspective" "float fov" [45] "float lensradius" 0.1 "float focaldistance" 4
Film "rgb" "integer xresolution" 64 "integer yresolution" [32] "string filename" "x.exr"
PixelFilter "box" "float xradius" .5
Sampler "zsobol" "integer pixelsamples" 16
Integrator "volpath" "integer maxdepth" [9]
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [10 9 8] "bool twosided" true
  Translate 0 0 3
  Shape "sphere" "float radius" 0.25
AttributeEnd
LightSource "infinite" "blackbody L" 5000 "float scale" 0.1
Texture "checks" "spectrum" "checkerboard" "rgb tex1" [.1 .2 .3] "float uscale" 4
MakeNamedMaterial "copper" "string type" "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" .1
Material "diffuse" "texture reflectance" "checks"
Shape "trianglemesh" "point3 P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] "integer indices" [0 1 2 0 2 3]
  "point2 uv" [0 0 1 0 1 1 0 1] "normal N" [0 0 1 0 0 1 0 0 1 0 0 1]
NamedMaterial "copper"
ObjectBegin "thing"
  Shape "cylinder" "float radius" 0.2 "float zmin" 0 "float zmax" 1
  AttributeBegin
    Scale 1 1 2
    Shape "sphere" "float radius" 0.3
  AttributeEnd
ObjectEnd
TransformBegin
  Rotate 30 0 0 1
  ObjectInstance "thing"
TransformEnd
Translate .5 0 0
ObjectInstance "thing"
)";

TEST(Pbrt, WholeSceneIsRead) {
  const Scene scene = parse_pbrt(everything, "s.pbrt");
  EXPECT_EQ(scene.resolution, ivec2(64, 32));
  EXPECT_EQ(scene.max_depth, 9);
  EXPECT_NEAR(scene.camera.fov, 45 * pi / 180, 1e-6);
  EXPECT_FLOAT_EQ(scene.camera.lens_radius, 0.1f);
  expect_near(scene.camera.to_world.point(vec3(0)), {0, -4, 0.5f});
  EXPECT_EQ(scene.objects.size(), 3u) << "the world, the cylinder, the stretched sphere";
  EXPECT_EQ(scene.instances.size(), 5u);
  EXPECT_EQ(scene.objects[0].geometry.triangles.size(), 2u);
  EXPECT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.textures.size(), 1u);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
  // The stretched sphere: placed by its own transform, then by the instance's.
  expect_near(scene.instances.at(4).to_world.point({0, 0, 0.3f}), {0.5f, 0, 0.6f});
}

TEST(Pbrt, ByteOrderMarkIsPassedOver) {
  EXPECT_EQ(parse_pbrt("\xef\xbb\xbf" + everything, "s.pbrt").hash(), parse_pbrt(everything, "s.pbrt").hash());
}

TEST(Pbrt, CameraLooksAlongItsTransform) {
  const Scene scene =
      parse_pbrt("LookAt 1 2 3  1 2 -7  0 1 0\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n" + triangle, "s.pbrt");
  const Ray ray = scene.camera.ray({8, 8}, {4, 4}, {0, 0});
  expect_near(ray.origin, {1, 2, 3});
  expect_near(ray.direction, {0, 0, -1});
  // pbrt's frame is left-handed: looking along -z with y up, +x lies to the left.
  EXPECT_LT(scene.camera.ray({8, 8}, {8, 4}, {0, 0}).direction.x, 0);
  EXPECT_EQ(scene.resolution, ivec2(1280, 720)) << "no Film: pbrt's default";
}

TEST(Pbrt, TransformsComposeAsPbrtHasThem) {
  const auto corner = [](const std::string& transforms) {
    return world(transforms + triangle).objects[0].geometry.positions.at(1);
  };
  expect_near(corner("Translate 1 2 3 Scale 2 2 2\n"), {3, 2, 3});
  expect_near(corner("Rotate 90 0 0 1\n"), {0, 1, 0});
  expect_near(corner("Transform [2 0 0 0  0 1 0 0  0 0 1 0  5 6 7 1]\n"), {7, 6, 7});
  expect_near(corner("Translate 1 0 0 ConcatTransform [0 1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1]\n"), {1, 1, 0});
  expect_near(corner("Translate 1 0 0 CoordinateSystem \"here\" Identity Translate 9 9 9 CoordSysTransform \"here\"\n"),
              {2, 0, 0});
  expect_near(corner("AttributeBegin Translate 5 5 5 AttributeEnd TransformBegin Scale 2 2 2 TransformEnd ActiveTransform All "
                     "TransformTimes 0 1\n"),
              {1, 0, 0});
  // LookAt gives world-to-camera: the eye goes to the origin, the target along +z.
  const Scene scene = world("LookAt 0 0 5  0 0 0  0 1 0\nLightSource \"point\" \"point3 from\" [0 0 5]\n" + triangle);
  expect_near(std::get<PointLight>(scene.lights.at(0)).position, vec3(0));
}

TEST(Pbrt, TransformsThatCannotBeAreErrors) {
  EXPECT_ERROR(world("Scale 1 0 1 " + triangle), "s.pbrt:3:9: Scale: a factor of 0");
  EXPECT_ERROR(world("Rotate 90 0 0 0 " + triangle), "s.pbrt:3:1: Rotate: the axis has no length");
  EXPECT_ERROR(world("LookAt 0 0 0 0 0 0 0 1 0 " + triangle), "s.pbrt:3:1: LookAt");
  EXPECT_ERROR(world("LookAt 0 0 0 0 1 0 0 1 0 " + triangle), "up points along the view");
  EXPECT_ERROR(world("Translate 1 2 x"), "s.pbrt:3:15: Translate: expected a number, found 'x'");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 2]"), "not affine");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 0 0 0  0 0 1 0  0 0 0 1] " + triangle), "no inverse");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1 3]"), "expected ] after 16 numbers");
  EXPECT_ERROR(world("CoordSysTransform \"worl\""), "s.pbrt:3:19: unknown coordinate system 'worl'; did you mean 'world'");
  EXPECT_ERROR(world("ActiveTransform Start"), "s.pbrt:3:17: ActiveTransform: expected All");
  EXPECT_ERROR(world("ActiveTransform StartTime"), "s.pbrt:3:17: ActiveTransform: nothing moves; --approximate takes");
  EXPECT_ERROR(world("Scale 1e30 1 1 Scale 1e30 1 1"), "leave the range");
}

// Exporters leave them where nothing is placed.
TEST(Pbrt, TransformsWithoutAnInverseMatterWhereSomethingIsPlaced) {
  const std::string flat = "AttributeBegin Scale 1 0 1 Translate 1 2 3 CoordinateSystem \"flat\" ";
  expect_near(world(flat + "AttributeEnd\n" + triangle).objects[0].geometry.positions.at(1), {1, 0, 0});
  expect_near(world(flat + "Identity " + triangle + "AttributeEnd").objects[0].geometry.positions.at(1), {1, 0, 0});
  EXPECT_ERROR(world(flat + "AttributeEnd CoordSysTransform \"flat\" LightSource \"point\""), "s.pbrt:3:24: Scale");
}

TEST(Pbrt, MotionStaysAtItsStart) {
  const std::string moves = "ActiveTransform EndTime Translate 9 9 9 Scale 1 0 1 ActiveTransform StartTime Translate 1 0 0 ";
  expect_near(approximated(moves + "ActiveTransform All " + triangle).objects[0].geometry.positions.at(1), {2, 0, 0});
  const Scene inside = approximated("AttributeBegin ActiveTransform EndTime AttributeEnd Translate 1 0 0\n" + triangle);
  expect_near(inside.objects[0].geometry.positions.at(1), {2, 0, 0});
  const Scene named = approximated("Translate 1 0 0 ActiveTransform EndTime CoordSysTransform \"world\" " + triangle);
  expect_near(named.objects[0].geometry.positions.at(1), {1, 0, 0});
  EXPECT_TRUE(warns(approximated(moves),
                    "s.pbrt:3:17: ActiveTransform: nothing moves: taken as the place at the start time, "
                    "without blur (and in 1 more places)"));
}

TEST(Pbrt, TransformBeginSavesAllAttributesInVersion4) {
  const std::string text =
      " WorldBegin Material \"matte\" \"rgb Kd\" [.25 .25 .25] TransformBegin Translate 9 0 0 AreaLightSource \"diffuse\" "
      "Material \"matte\" \"rgb Kd\" [.75 .75 .75] Shape \"sphere\" TransformEnd Shape \"sphere\"";
  for (const bool version3 : {true, false}) {
    const Scene scene = parse_pbrt((version3 ? "Film \"image\"" : "Film \"rgb\"") + text, "s.pbrt");
    const Object& object = scene.objects[0];
    expect_near(std::get<Sphere>(object.geometry.quadrics.at(1)).centre + scene.origin, {0, 0, 0});
    EXPECT_EQ(std::get<Diffuse>(scene.materials.at(object.shape(1).material)).reflectance.constant,
              Rgb(version3 ? 0.75f : 0.25f));
    EXPECT_EQ(scene.lights.size(), version3 ? 2u : 1u);
  }
}

TEST(Pbrt, AttributeGivesWhatIsNotGiven) {
  const Scene scene = world(
      "Attribute \"shape\" \"float radius\" 3 AttributeBegin Attribute \"shape\" \"float radius\" 4 Shape \"sphere\" "
      "AttributeEnd Shape \"sphere\" Shape \"sphere\" \"float radius\" 5\n" +
      triangle);
  const auto& quadrics = scene.objects[0].geometry.quadrics;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(std::get<Sphere>(quadrics.at(i)).radius, i == 0 ? 4 : i == 1 ? 3 : 5);
  EXPECT_ERROR(world("Attribute \"shap\" \"float radius\" 1"), "unknown target of Attribute 'shap'; did you mean 'shape'");
  std::string blocks = "Attribute \"shape\" \"float radius\" 3", ends;
  for (int i = 0; i < 1024; ++i) blocks += "\nAttributeBegin", ends += " AttributeEnd";
  EXPECT_EQ(std::get<Sphere>(world(blocks + " Shape \"sphere\"" + ends).objects[0].geometry.quadrics.at(0)).radius, 3);
  EXPECT_ERROR(world(blocks + "\nAttributeBegin"), "s.pbrt:1028:1: blocks nest more than 1024 deep");
}

TEST(Pbrt, MediaAreLeftOutOnRequest) {
  for (const char* text : {"MakeNamedMedium \"m\" \"string type\" \"homogeneous\"\n", "MediumInterface \"a\" \"b\"\n"}) {
    EXPECT_ERROR(world(text), "is not supported: there are no participating media");
    EXPECT_TRUE(warns(approximated(text), "s.pbrt:3:1: M"));
    EXPECT_TRUE(warns(approximated(text), "vacuum"));
  }
  EXPECT_TRUE(world("MediumInterface \"\" \"\" " + triangle).objects[0].geometry.triangles.size() == 1);
}

TEST(Pbrt, BlocksMustMatch) {
  EXPECT_ERROR(world("AttributeEnd"), "s.pbrt:3:1: AttributeEnd without AttributeBegin");
  EXPECT_ERROR(world("AttributeBegin\nTransformEnd"), "s.pbrt:4:1: TransformEnd inside the AttributeBegin of line 3");
  EXPECT_ERROR(world("  AttributeBegin"), "s.pbrt:3:3: AttributeBegin is never closed");
  EXPECT_ERROR(world("ObjectBegin \"a\""), "ObjectBegin is never closed");
  EXPECT_ERROR(parse_pbrt("Camera \"perspective\"", "s.pbrt"), "s.pbrt: the file has no WorldBegin");
  EXPECT_ERROR(parse_pbrt(triangle, "s.pbrt"), "s.pbrt:1:1: Shape must stand after WorldBegin");
  EXPECT_ERROR(world("Film \"rgb\""), "s.pbrt:3:1: Film must stand before WorldBegin");
  EXPECT_ERROR(world("WorldEnd\n" + triangle), "s.pbrt:4:1: Shape after WorldEnd");
}

TEST(Pbrt, LexicalErrorsNameTheirPlace) {
  EXPECT_ERROR(world("Shap \"sphere\""), "s.pbrt:3:1: unknown directive 'Shap'; did you mean 'Shape'");
  EXPECT_ERROR(world("\"sphere\""), "s.pbrt:3:1: expected a directive, found the string 'sphere'");
  EXPECT_ERROR(world("Shape \"sphere"), "s.pbrt:3:7: this string has no closing quote");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" [1 2"),
               "s.pbrt:3:16: the values of \"float radius\" have no closing ]");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" 1.2.3"), "s.pbrt:3:31: '1.2.3' is not a number");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" 1e99"),
               "s.pbrt:3:31: '1e99' is not a number that single precision holds");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" \"x\""),
               "s.pbrt:3:31: expected a number for \"float radius\", found the string 'x'");
  EXPECT_ERROR(world("Shape \"sphere\" \"radius\" 1"), "s.pbrt:3:16: Shape \"sphere\": expected a parameter as \"type name\"");
  EXPECT_ERROR(world("Shape \"sphere\" \"floot radius\" 1"), "unknown parameter type 'floot'; did you mean 'float'");
  const Scene twice = world("Shape \"sphere\" \"float radius\" 1 \"float radius\" 2");
  EXPECT_TRUE(warns(twice, "s.pbrt:3:33: Shape \"sphere\": 'radius' is given twice; the last one counts"));
  EXPECT_EQ(std::get<Sphere>(twice.objects[0].geometry.quadrics.at(0)).radius, 2);
  EXPECT_ERROR(world("Shape \"trianglemesh\" \"integer indices\" [0 1.5 2]"), "s.pbrt:3:43: expected a whole number");
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" \"bool twosided\" maybe"), "expected true or false");
  EXPECT_ERROR(world("@"), "s.pbrt:3:1: expected a directive, a string or a number, found '@'");
  EXPECT_ERROR(world("Shape sphere"), "s.pbrt:3:7: Shape: expected a string, found 'sphere'");
}

// Each parameter is compared with each: 40,000 in one directive took minutes.
TEST(Pbrt, EndlessParametersAreAnError) {
  std::string many, again;
  for (int i = 0; i < 1001; ++i) many += fmt::format(" \"float p{}\" 1", i), again += " \"float radius\" 2";
  EXPECT_ERROR(world("Shape \"sphere\"" + many), "Shape \"sphere\": more than 1000 parameters");
  EXPECT_EQ(std::get<Sphere>(world("Shape \"sphere\"" + again).objects[0].geometry.quadrics.at(0)).radius, 2);
  const std::string half = many.substr(0, many.find(" \"float p1000\""));
  EXPECT_ERROR(world("Attribute \"shape\"" + half + "\nAttribute \"shape\" \"float q\" 1"),
               "s.pbrt:4:1: Attribute \"shape\": more than 1000 parameters for what follows");
}

TEST(Pbrt, LexerUnderstandsCommentsEscapesAndNumbers) {
  const Scene scene = world("Shape#c\r\n\"sphere\"\t\"float radius\"[ +2.5e0 ]# end\rTranslate 1 .5 -.5 LightSource \"point\"");
  EXPECT_FLOAT_EQ(std::get<Sphere>(scene.objects[0].geometry.quadrics.at(0)).radius, 2.5f);
  expect_near(std::get<PointLight>(scene.lights.at(0)).position, {1, 0.5f, -0.5f});
  EXPECT_ERROR(world("NamedMaterial \"a\\\"b\\\\\""), "unknown named material 'a\"b\\'");
}

TEST(Pbrt, UnreadParametersAreErrors) {
  EXPECT_ERROR(world("Shape \"sphere\"\n  \"float radios\" 1"),
               "s.pbrt:4:3: Shape \"sphere\": unknown parameter 'radios'; did you mean 'radius'");
  EXPECT_ERROR(world("Material \"diffuse\" \"rgb Kd\" [1 1 1]"), "Material \"diffuse\": unknown parameter 'Kd'");
  EXPECT_ERROR(world("LightSource \"point\" \"float lumens\" 3"), "unknown parameter 'lumens'");
  EXPECT_ERROR(world("Shape \"sphere\" \"rgb radius\" [1 1 1]"),
               "s.pbrt:3:16: Shape \"sphere\": 'radius' is of type rgb; expected float");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" [1 2]"), "'radius' has 2 values; expected one");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" []"), "'radius' has 0 values");
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" -1"), "'radius' is -1; expected");
}

// pbrt-v3 only warns of them.
TEST(Pbrt, UnreadParametersOfVersion3AreWarnedOfUnlessMisspelt) {
  const auto read = [](const std::string& text, bool approximate = false) {
    return parse_pbrt("Film \"image\"\nWorldBegin\n" + text, "s.pbrt", {.approximate = approximate});
  };
  const std::string left_over = "Material \"matte\" \"rgb Kd\" [.1 .2 .3]\n  \"rgb Ks\" [1 1 1] ";
  const Scene matte = read(left_over + triangle);
  EXPECT_TRUE(warns(matte, "s.pbrt:4:3: Material \"matte\": 'Ks' has no effect, as in pbrt-v3"));
  expect_near(std::get<Diffuse>(matte.materials.at(0)).reflectance.constant, {0.1f, 0.2f, 0.3f});
  EXPECT_TRUE(warns(read("Shape \"sphere\" \"integer udiv\" 4"), "'udiv' has no effect, as in pbrt-v3"));
  std::string many;
  for (int i = 0; i < 1200; ++i) many += fmt::format("Shape \"sphere\" \"integer udiv\" 4 \"integer zz{}\" 4 ", i);
  const Scene spheres = read(many);
  EXPECT_TRUE(warns(spheres, "(1200 times in all)"));
  EXPECT_TRUE(warns(spheres, "more warnings of what the files hold"));
  EXPECT_LT(spheres.warnings.size(), 1010u);
  EXPECT_ERROR(read("Shape \"sphere\" \"float radios\" 1"), "unknown parameter 'radios'; did you mean 'radius'");
  EXPECT_ERROR(world(left_over + triangle), "unknown parameter 'Ks'");
  const Scene light = read("LightSource \"point\" \"float power\" 100 " + triangle);
  EXPECT_TRUE(warns(light, "'power' has no effect, as in pbrt-v3"));
  expect_near(std::get<PointLight>(light.lights.at(0)).intensity, Rgb(1));
  const std::string own = "Material \"matte\" Shape \"sphere\" \"rgb Kd\" [1 0 0]";
  EXPECT_ERROR(read(own),
               "s.pbrt:3:33: Shape \"sphere\": 'Kd' changes the material for this shape alone in pbrt-v3, which is not");
  EXPECT_TRUE(warns(read(own, true), "'Kd' changes the material for this shape alone"));
  EXPECT_ERROR(world(own), "unknown parameter 'Kd'");
}

TEST(Pbrt, IntegersThatVersion3DoesNotTakeForFloatsAreTold) {
  const std::string rest = " Camera \"perspective\" \"integer fov\" 40 WorldBegin " + triangle;
  const std::string told = "Camera \"perspective\": 'fov' is an integer, which counts here; pbrt-v3 expects a float";
  const Scene version3 = parse_pbrt("Film \"image\"" + rest, "s.pbrt");
  EXPECT_NEAR(version3.camera.fov, 40 * pi / 180, 1e-6);
  EXPECT_TRUE(warns(version3, told));
  EXPECT_FALSE(warns(parse_pbrt("Film \"rgb\"" + rest, "s.pbrt"), told));
}

// pbrt-v4 puts names together once all is read.
TEST(Pbrt, NamesThatMayStandFurtherDownAreTold) {
  const std::string told = "pbrt-v4 also finds what is defined further down, but here it must stand before its use";
  const std::string uses[] = {"NamedMaterial \"m\"", "Material \"diffuse\" \"texture reflectance\" \"t\"",
                              "ObjectInstance \"o\"", "Material \"mix\" \"string materials\" [\"a\" \"b\"]"};
  for (const std::string& use : uses) {
    EXPECT_ERROR(world(use), told);
    EXPECT_FALSE(contains(error_of([&] { (void)parse_pbrt("Film \"image\" WorldBegin " + use, "s.pbrt"); }), told)) << use;
  }
}

TEST(Pbrt, FilesOfOlderVersionsAreTold) {
  EXPECT_ERROR(parse_pbrt("Film \"image\"\nSurfaceIntegrator \"path\"", "s.pbrt"),
               "s.pbrt:2:1: SurfaceIntegrator is of pbrt's versions 1 and 2");
}

TEST(Pbrt, MessagesNameOnePlace) {
  const TestDirectory directory;
  directory.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string scene = directory.path("s.pbrt");
  const auto error = [&](const std::string& text) { return error_of([&] { (void)parse_pbrt("WorldBegin\n" + text, scene); }); };
  const std::string mesh = error("Shape \"plymesh\" \"string filename\" \"m.obj\"\n  \"texture alpha\" \"nope\"");
  EXPECT_TRUE(mesh.starts_with(scene + ":3:3: Shape")) << mesh;
  EXPECT_EQ(mesh.find(scene, 1), std::string::npos) << mesh;
  const std::string light = error("LightSource \"infinite\" \"spectrum L\" \"stdillum-D50\"");
  EXPECT_TRUE(light.starts_with(scene + ":2:24: 'stdillum-D50' is not supported in full; --approximate takes")) << light;
}

TEST(Pbrt, UnsupportedThingsAreNamed) {
  EXPECT_ERROR(world("Shape \"torus\""), "s.pbrt:3:7: unknown shape 'torus'; available: trianglemesh plymesh");
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" 0.5"), "a light that is half transparent");
  EXPECT_ERROR(world("Shape \"sphere\" \"float shadowalpha\" 0.5"), "'shadowalpha' that is not 'alpha' is not supported");
  EXPECT_ERROR(world("Material \"subsurfac\""), "unknown material 'subsurfac'; did you mean 'subsurface'");
  EXPECT_ERROR(world("Material \"subsurface\""), "s.pbrt:3:10: material \"subsurface\" is not supported; --approximate takes");
  EXPECT_ERROR(world("LightSource \"goniometric\""), "LightSource \"goniometric\": lights have no image; --approximate takes");
  EXPECT_ERROR(world("LightSource \"laser\""), "unknown light 'laser'; available: point spot distant infinite");
  EXPECT_ERROR(world("Texture \"t\" \"spectrum\" \"marbles\""), "unknown texture 'marbles'; did you mean 'marble'");
  EXPECT_ERROR(world("ColorSpace \"rec2020\""), "ColorSpace \"rec2020\" is not supported; --approximate takes srgb");
  EXPECT_ERROR(parse_pbrt("Camera \"spherical\"", "s.pbrt"), "s.pbrt:1:8: Camera \"spherical\" is not supported");
  EXPECT_ERROR(parse_pbrt("Camera \"fisheye\"", "s.pbrt"), "s.pbrt:1:8: unknown camera 'fisheye'");
}

TEST(Pbrt, FilmAndCameraOptionsThatChangeTheImageAreChecked) {
  const auto with = [](const std::string& options) { return parse_pbrt(options + "\nWorldBegin\n" + triangle, "s.pbrt"); };
  EXPECT_EQ(with("Camera \"perspective\" Film \"image\"").resolution, ivec2(1280, 720));
  EXPECT_EQ(with("Camera \"perspective\" Film \"rgb\"").resolution, ivec2(1280, 720));
  const std::string film = "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 ";
  EXPECT_EQ(with(film + "Camera \"perspective\" \"float screenwindow\" [-2 2 -1 1] \"float frameaspectratio\" 2").resolution,
            ivec2(200, 100));
  EXPECT_ERROR(with(film + "Camera \"perspective\" \"float screenwindow\" [-1 1 -1 1]"), "only the 'screenwindow' [-2 2 -1 1]");
  EXPECT_ERROR(with(film + "Camera \"perspective\" \"float screenwindow\" [-1 3 -1 1]"), "only the 'screenwindow' [-2 2 -1 1]");
  EXPECT_NEAR(with(film + "Camera \"perspective\" \"float screenwindow\" [-1 1 -.5 .5] \"float fov\" 90").camera.fov,
              2 * std::atan(0.5), 1e-5)
      << "a smaller window narrows the view";
  EXPECT_ERROR(with(film + "Camera \"perspective\" \"float frameaspectratio\" 1"), "frameaspectratio");
  EXPECT_EQ(with(film + "\"float iso\" 200 \"float exposuretime\" 0.5 \"string sensor\" \"cie1931\"").resolution,
            ivec2(200, 100));
  EXPECT_ERROR(with(film + "\"string sensor\" \"canon_eos_5d\""), "only cie1931");
  const std::array<float, 4> left_half{0, 0.5f, 0, 1}, upper_left{0, 0.5f, 0, 0.5f};
  EXPECT_EQ(with(film + "\"float cropwindow\" [0 .5 0 1]").crop, left_half);
  EXPECT_EQ(with(film + "\"integer pixelbounds\" [0 100 0 50]").crop, upper_left);
  EXPECT_TRUE(warns(with(film + "\"float cropwindow\" [0 .5 0 1]"), "`etendue render` shows that part"));
  EXPECT_FALSE(with(film + "\"float cropwindow\" [0 1 0 1]").crop.has_value());
  EXPECT_ERROR(with(film + "\"float cropwindow\" [.5 .5 0 1]"), "'cropwindow' is empty, or no part of the image");
  EXPECT_ERROR(with("Film \"rgb\" \"integer xresolution\" 0"), "'xresolution' is 0; expected 1 to 65536");
  EXPECT_TRUE(warns(with(film + "\"float maxcomponentvalue\" 10"), "clamping would bias"));
  EXPECT_TRUE(warns(with("Camera \"perspective\" \"float shutteropen\" 0.1"), "nothing moves"));
  EXPECT_TRUE(warns(with(""), "no Camera"));
  EXPECT_TRUE(warns(with(""), "no lights"));
  EXPECT_FALSE(with("Integrator \"path\"").max_depth.has_value());
  EXPECT_ERROR(with("Integrator \"path\" \"integer maxdepth\" -1"), "'maxdepth' is -1");
  EXPECT_EQ(
      with("Sampler \"halton\" \"integer pixelsamples\" 4 Accelerator \"bvh\" Option \"integer seed\" 3 ColorSpace \"srgb\"")
          .max_depth,
      std::nullopt);
}

TEST(Pbrt, ExposureScalesTheLights) {
  const auto lights = [](const std::string& film) {
    return parse_pbrt("Film " + film +
                          " WorldBegin LightSource \"point\" LightSource \"infinite\" \"rgb L\" [1 2 3] AreaLightSource "
                          "\"diffuse\" " +
                          triangle,
                      "s.pbrt")
        .lights;
  };
  const auto scaled = lights("\"rgb\" \"float iso\" 150 \"float exposuretime\" 2");
  expect_near(std::get<PointLight>(scaled.at(0)).intensity, Rgb(3));
  expect_near(std::get<EnvironmentLight>(scaled.at(1)).scale, {3, 6, 9});
  expect_near(std::get<AreaLight>(scaled.at(2)).radiance, Rgb(3));
  expect_near(std::get<PointLight>(lights("\"image\" \"float scale\" 0.25").at(0)).intensity, Rgb(0.25f));
  EXPECT_ERROR(lights("\"image\" \"float scale\" 1e9 \"float iso\" 1e8"), "Film: scaled, a light is beyond");
}

TEST(Pbrt, OrthographicCamerasSeeAlongParallels) {
  const auto corner = [](const std::string& before, const std::string& window) {
    const Scene scene = parse_pbrt("Film \"image\" \"integer xresolution\" 200 \"integer yresolution\" 100 " + before +
                                       " Camera \"orthographic\" " + window + " WorldBegin " + triangle,
                                   "s.pbrt");
    const Ray ray = scene.camera.ray({200, 100}, {200, 0}, {0, 0});
    expect_near(ray.direction, {0, 0, 1});
    return ray.origin + scene.origin;
  };
  expect_near(corner("", ""), {2, 1, 0});
  expect_near(corner("", "\"float screenwindow\" [-4 4 -2 2]"), {4, 2, 0});
  expect_near(corner("", "\"float screenwindow\" [0 8 0 4]"), {8, 4, 0});
  expect_near(corner("Scale 0.5 0.5 0.5", ""), {4, 2, 0});
  EXPECT_ERROR(corner("Scale 1 2 1", ""), "its transform distorts the image");
  EXPECT_ERROR(corner("", "\"float screenwindow\" [-1 1 -1 1]"), "that fits the film is supported");
  EXPECT_ERROR(corner("", "\"float lensradius\" 1"), "'lensradius' is not supported");
}

TEST(PbrtFiles, IncludeImportAndMeshesAreFoundFromTheirFile) {
  const TestDirectory directory;
  const std::string main = directory.write(
      "main.pbrt", "Camera \"perspective\"\nWorldBegin\nInclude \"parts/a.pbrt\"\nImport \"parts/b.pbrt\"\n" + triangle);
  directory.write("parts/a.pbrt", "Translate 1 0 0\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n");
  directory.write("parts/b.pbrt",
                  "Translate 0 0 9 Material \"mirror\"\nShape \"plymesh\" \"string filename\" \"parts/mesh.ply\"\n");
  directory.write(
      "parts/mesh.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene scene = load_scene(main);
  EXPECT_EQ(scene.name, main);
  ASSERT_EQ(scene.objects[0].shapes.size(), 3u);
  expect_near(scene.objects[0].geometry.positions[3], {1, 0, 9});
  expect_near(scene.objects[0].geometry.positions[6], {1, 0, 0});  // Include's Translate stays, Import's does not
  EXPECT_TRUE(std::holds_alternative<Diffuse>(scene.materials.at(scene.objects[0].shapes[2].material)));

  directory.write("parts/a.pbrt", "Shape \"plymesh\"\n  \"string filename\" \"absent.ply\"\n");
  EXPECT_ERROR(load_scene(main), "parts/a.pbrt:2:3: cannot open");
  directory.write("parts/a.pbrt", "Shape \"spher\"");
  EXPECT_ERROR(load_scene(main), "parts/a.pbrt:1:7: unknown shape 'spher'; did you mean 'sphere'");
  directory.write("parts/mesh.ply", "ply\nformat");
  directory.write("parts/a.pbrt", "Shape \"plymesh\" \"string filename\" \"mesh.ply\"");
  EXPECT_ERROR(load_scene(main), "mesh.ply:2:7: unknown format");
  EXPECT_ERROR(world("Include \"absent.pbrt\""), "s.pbrt:3:9: cannot open 'absent.pbrt'");
}

TEST(PbrtFiles, CoordinateSystemsAcrossImportsAreTold) {
  const TestDirectory directory;
  const auto read = [&](const std::string& main, const std::string& imported) {
    directory.write("part.pbrt", imported);
    return load_scene(directory.write("main.pbrt", "Translate 0 0 5 Camera \"perspective\" WorldBegin " + main + triangle));
  };
  const std::string part = "Import \"part.pbrt\" ", there = "CoordSysTransform \"a\" ", light = "LightSource \"point\" ",
                    name = "Translate 1 0 0 CoordinateSystem \"a\" ", told = "named on the other side of an Import";
  const Scene by_camera = read(part, "CoordSysTransform \"camera\" " + light);
  expect_near(std::get<PointLight>(by_camera.lights.at(0)).position + by_camera.origin, {0, 0, -5});
  EXPECT_TRUE(warns(by_camera, "part.pbrt:1:19: CoordSysTransform: 'camera' is " + told));
  EXPECT_TRUE(warns(read(part + there + light, name), told));
  EXPECT_FALSE(warns(read(part + light, name + there), told));
  EXPECT_FALSE(warns(read(name + part + there + light, light), told));
}

TEST(PbrtFiles, EndlessInclusionIsAnError) {
  const TestDirectory directory;
  const std::string main = directory.write("main.pbrt", "WorldBegin\nInclude \"again.pbrt\"");
  directory.write("again.pbrt", "Include \"again.pbrt\"");
  EXPECT_ERROR(load_scene(main), "again.pbrt:1:9: files include each other more than 32 deep");
}

TEST(Pbrt, DamagedFilesNeitherCrashNorHang) {
  damage(everything, 3000, [](const std::string& text) { parse_pbrt(text, "s.pbrt"); });
}

}  // namespace
}  // namespace etendue
