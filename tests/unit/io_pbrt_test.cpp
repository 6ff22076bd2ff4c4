#include "framework/io/exr.h"
#include "framework/io/image_file.h"
#include "framework/io/load_scene.h"
#include "framework/io/pbrt.h"
#include "framework/io/spectra.h"
#include "framework/scene/intersect.h"
#include "tests/unit/io_helpers.h"

namespace etendue {
namespace {

const std::string triangle = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

Scene world(const std::string& text) { return parse_pbrt("Camera \"perspective\"\nWorldBegin\n" + text, "s.pbrt"); }
template <class T>
T material_of(const std::string& directive) {
  const Scene scene = world(directive + "\n" + triangle);
  return std::get<T>(scene.materials.at(scene.objects[0].shapes.at(0).material));
}
template <class T>
T light_of(const std::string& directive) {
  return std::get<T>(world(directive + "\n" + triangle).lights.at(0));
}
void expect_near(const vec3& a, const vec3& b, float tolerance = 1e-5f) {
  EXPECT_TRUE(glm::length(a - b) <= tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}
bool warns(const Scene& scene, const std::string& text) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const std::string& w) { return w.find(text) != std::string::npos; });
}

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

TEST(Pbrt, CameraLooksAlongItsTransform) {
  const Scene scene =
      parse_pbrt("LookAt 1 2 3  1 2 -7  0 1 0\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n" + triangle, "s.pbrt");
  const Ray ray = scene.camera.ray({8, 8}, {4, 4}, {0, 0});
  expect_near(ray.origin, {1, 2, 3});
  expect_near(ray.direction, {0, 0, -1});
  // pbrt's frame is left-handed: looking along -z with y up, +x lies to the left.
  EXPECT_LT(scene.camera.ray({8, 8}, {8, 4}, {0, 0}).direction.x, 0);
  EXPECT_EQ(scene.resolution, ivec2(256, 256)) << "no Film: the scene's default";
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
  expect_near(
      corner("AttributeBegin Translate 5 5 5 AttributeEnd TransformBegin Scale 2 2 2 TransformEnd ActiveTransform All\n"),
      {1, 0, 0});
  // LookAt gives world-to-camera: the eye goes to the origin, the target along +z.
  const Scene scene = world("LookAt 0 0 5  0 0 0  0 1 0\nLightSource \"point\" \"point3 from\" [0 0 5]\n" + triangle);
  expect_near(std::get<PointLight>(scene.lights.at(0)).position, vec3(0));
}

TEST(Pbrt, TransformsThatCannotBeAreErrors) {
  EXPECT_ERROR(world("Scale 1 0 1"), "s.pbrt:3:9: Scale: a factor of 0");
  EXPECT_ERROR(world("Rotate 90 0 0 0"), "s.pbrt:3:1: Rotate: the axis has no length");
  EXPECT_ERROR(world("LookAt 0 0 0 0 0 0 0 1 0"), "s.pbrt:3:1: LookAt");
  EXPECT_ERROR(world("LookAt 0 0 0 0 1 0 0 1 0"), "up points along the view");
  EXPECT_ERROR(world("Translate 1 2 x"), "s.pbrt:3:15: Translate: expected a number, found 'x'");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 2]"), "not affine");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 0 0 0  0 0 1 0  0 0 0 1]"), "no inverse");
  EXPECT_ERROR(world("Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1 3]"), "expected ] after 16 numbers");
  EXPECT_ERROR(world("CoordSysTransform \"worl\""), "s.pbrt:3:19: unknown coordinate system 'worl'; did you mean 'world'");
  EXPECT_ERROR(world("ActiveTransform StartTime"), "s.pbrt:3:17: ActiveTransform: expected All");
  EXPECT_ERROR(world("Scale 1e30 1 1 Scale 1e30 1 1"), "leave the range");
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
  EXPECT_ERROR(world("Shape \"sphere\" \"float radius\" 1 \"float radius\" 2"),
               "s.pbrt:3:33: Shape \"sphere\": 'radius' is given twice");
  EXPECT_ERROR(world("Shape \"trianglemesh\" \"integer indices\" [0 1.5 2]"), "s.pbrt:3:43: expected a whole number");
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" \"bool twosided\" maybe"), "expected true or false");
  EXPECT_ERROR(world("@"), "s.pbrt:3:1: expected a directive, a string or a number, found '@'");
  EXPECT_ERROR(world("Shape sphere"), "s.pbrt:3:7: Shape: expected a string, found 'sphere'");
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

TEST(Pbrt, UnsupportedThingsAreNamed) {
  for (const char* text :
       {"Attribute \"shape\" \"float radius\" 1", "MakeNamedMedium \"m\"", "MediumInterface \"a\" \"b\"", "TransformTimes 0 1"})
    EXPECT_ERROR(world(text), "is not supported");
  EXPECT_ERROR(world("Shape \"loopsubdiv\""),
               "s.pbrt:3:7: unknown shape 'loopsubdiv'; available: trianglemesh plymesh sphere cylinder disk");
  EXPECT_ERROR(world("Shape \"sphere\" \"float phimax\" 90"), "only full shapes are supported");
  EXPECT_ERROR(world("Shape \"sphere\" \"float zmin\" -0.5"), "only full shapes are supported");
  EXPECT_ERROR(world("Shape \"sphere\" \"float alpha\" 0.5"), "'alpha' is not supported");
  EXPECT_ERROR(world("Material \"subsurface\""), "unknown material 'subsurface'; available: diffuse matte");
  EXPECT_ERROR(world("Material \"\""), "material '' is not supported");
  EXPECT_ERROR(world("Material \"interface\""), "material 'interface' is not supported");
  EXPECT_ERROR(world("LightSource \"goniometric\""), "unknown light 'goniometric'; available: point spot distant infinite");
  EXPECT_ERROR(world("Texture \"t\" \"spectrum\" \"marble\""), "unknown texture 'marble'");
  EXPECT_ERROR(world("ColorSpace \"rec2020\""), "unknown colour space 'rec2020'");
  EXPECT_ERROR(parse_pbrt("Camera \"orthographic\"", "s.pbrt"), "s.pbrt:1:8: unknown camera 'orthographic'");
}

TEST(Pbrt, FilmAndCameraOptionsThatChangeTheImageAreChecked) {
  const auto with = [](const std::string& options) { return parse_pbrt(options + "\nWorldBegin\n" + triangle, "s.pbrt"); };
  EXPECT_EQ(with("Camera \"perspective\" Film \"image\"").resolution, ivec2(640, 480));
  EXPECT_EQ(with("Camera \"perspective\" Film \"rgb\"").resolution, ivec2(1280, 720));
  const std::string film = "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 ";
  EXPECT_EQ(with(film + "Camera \"perspective\" \"float screenwindow\" [-2 2 -1 1] \"float frameaspectratio\" 2").resolution,
            ivec2(200, 100));
  EXPECT_ERROR(with(film + "Camera \"perspective\" \"float screenwindow\" [-1 1 -1 1]"), "only the 'screenwindow' [-2 2 -1 1]");
  EXPECT_ERROR(with(film + "Camera \"perspective\" \"float frameaspectratio\" 1"), "frameaspectratio");
  EXPECT_ERROR(with(film + "\"float iso\" 200"), "'iso' scales the image by 2");
  EXPECT_EQ(with(film + "\"float iso\" 200 \"float exposuretime\" 0.5 \"string sensor\" \"cie1931\"").resolution,
            ivec2(200, 100));
  EXPECT_ERROR(with(film + "\"string sensor\" \"canon_eos_5d\""), "only cie1931");
  EXPECT_ERROR(with(film + "\"float cropwindow\" [0 .5 0 1]"), "'cropwindow' is not supported");
  EXPECT_ERROR(with("Film \"rgb\" \"integer xresolution\" 0"), "'xresolution' is 0; expected 1 to 65536");
  EXPECT_TRUE(warns(with(film + "\"float maxcomponentvalue\" 10"), "clamping would bias"));
  EXPECT_TRUE(warns(with("PixelFilter \"gaussian\" \"float xradius\" 2"), "filtered with a box"));
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

TEST(PbrtShapes, TriangleMeshesAreChecked) {
  const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0] ";
  EXPECT_ERROR(world("Shape \"trianglemesh\""), "'P' is missing");
  EXPECT_ERROR(world(mesh), "'indices' is missing");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1]"), "expected three per triangle");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1 4]"), "has 4 as its value 2, but there are 4 points");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 -1 2]"), "has -1 as its value 1");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1 2] \"normal N\" [0 0 1]"), "has 1 normals, but there are 4 points");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1 2] \"float uv\" [0 0 1]"), "expected pairs");
  EXPECT_ERROR(world("Shape \"trianglemesh\" \"point P\" [0 0 0 1]"), "expected triples");
  const Scene scene =
      world(mesh + "\"integer indices\" [0 1 2 1 2 3] \"float st\" [0 0 1 0 0 1 1 1] \"vector S\" [1 0 0 1 0 0 1 0 0 1 0 0]\n" +
            triangle);
  EXPECT_TRUE(warns(scene, "tangents"));
  ASSERT_EQ(scene.objects[0].shapes.size(), 2u);
  EXPECT_TRUE(scene.objects[0].shapes[0].has_uvs);
  EXPECT_FALSE(scene.objects[0].shapes[1].has_uvs);
  EXPECT_EQ(scene.objects[0].uvs.size(), scene.objects[0].geometry.positions.size());
  EXPECT_EQ(scene.objects[0].geometry.triangles.at(2), uvec3(4, 5, 6));
}

// The geometric normal where a ray straight down meets the scene near the origin.
vec3 normal_below(const Scene& scene, const vec3& origin) {
  const Ray ray{.origin = origin, .direction = {0, 0, -1}};
  Hit hit;
  const Geometry& g = scene.objects[0].geometry;
  const TriangleRay shear(ray.direction);
  for (std::uint32_t i = 0; i < g.primitive_count(); ++i) intersect_primitive(g, i, ray, shear, hit);
  hit.instance = 0;
  return hit ? scene.surface_at(ray, hit).normal : vec3(0);
}

TEST(PbrtShapes, OrientationFollowsWindingReversalAndHandedness) {
  const vec3 above(0.25f, 0.25f, 1), mirrored(-0.25f, 0.25f, 1);
  const std::string with_normals =
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] \"normal3 N\" [0 0 -1 0 0 -1 0 0 -1]\n";
  expect_near(normal_below(world(triangle), above), {0, 0, 1});
  expect_near(normal_below(world("ReverseOrientation " + triangle), above), {0, 0, -1});
  // Mirrored, the winding as placed points down; the handedness turns it back up.
  expect_near(normal_below(world("Scale -1 1 1 " + triangle), mirrored), {0, 0, 1});
  expect_near(normal_below(world("ReverseOrientation Scale -1 1 1 " + triangle), mirrored), {0, 0, -1});
  expect_near(normal_below(world(with_normals), above), {0, 0, -1});
  expect_near(normal_below(world("ReverseOrientation " + with_normals), above), {0, 0, 1});
  for (const char* mirror : {"", "Scale -1 1 1 "}) {
    expect_near(normal_below(world(std::string(mirror) + "Shape \"sphere\""), {0, 0, 3}), {0, 0, 1});
    expect_near(normal_below(world(std::string(mirror) + "ReverseOrientation Shape \"sphere\""), {0, 0, 3}), {0, 0, -1});
    expect_near(normal_below(world(std::string(mirror) + "Shape \"disk\""), above), {0, 0, 1});
  }
}

TEST(PbrtShapes, NormalsGoByTheInverseTranspose) {
  const Scene scene =
      world("Scale 2 1 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 -1  0 1 0] \"normal3 N\" [1 0 1 1 0 1 1 0 1]");
  expect_near(scene.objects[0].normals.at(0), glm::normalize(vec3(0.5f, 0, 1)));
}

TEST(PbrtShapes, QuadricsUnderSimilaritiesArePlacedDirectly) {
  const Scene scene = world(
      "Translate 1 2 3 Scale 2 2 2 Rotate 90 0 1 0\nShape \"sphere\" \"float radius\" 0.5\n"
      "Shape \"cylinder\" \"float radius\" 0.25 \"float zmin\" 1 \"float zmax\" -1\nShape \"disk\" \"float height\" 1 \"float "
      "innerradius\" 0.5");
  EXPECT_EQ(scene.instances.size(), 1u);
  const auto& quadrics = scene.objects[0].geometry.quadrics;
  ASSERT_EQ(quadrics.size(), 3u);
  const Sphere sphere = std::get<Sphere>(quadrics[0]);
  expect_near(sphere.centre, {1, 2, 3});
  EXPECT_FLOAT_EQ(sphere.radius, 1);
  const Cylinder cylinder = std::get<Cylinder>(quadrics[1]);
  expect_near(cylinder.base, {-1, 2, 3});
  expect_near(cylinder.axis, {1, 0, 0});
  EXPECT_FLOAT_EQ(cylinder.length, 4);
  EXPECT_FLOAT_EQ(cylinder.radius, 0.5f);
  EXPECT_FALSE(cylinder.caps);
  const Disk disk = std::get<Disk>(quadrics[2]);
  expect_near(disk.centre, {3, 2, 3});
  expect_near(disk.normal, {1, 0, 0});
  EXPECT_FLOAT_EQ(disk.inner_radius, 1);
}

TEST(PbrtShapes, DistortedQuadricsBecomeInstances) {
  const Scene scene = world("Translate 1 0 0 Scale 1 2 3 Shape \"sphere\" \"float radius\" 0.5");
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_FLOAT_EQ(std::get<Sphere>(scene.objects.at(1).geometry.quadrics.at(0)).radius, 0.5f);
  expect_near(scene.instances[1].to_world.point({0, 0.5f, 0}), {1, 1, 0});
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" Scale 1 2 3 Shape \"sphere\""),
               "s.pbrt:3:39: Shape \"sphere\": a shape under a transform that distorts it cannot emit");
  EXPECT_ERROR(world("Shape \"disk\" \"float innerradius\" 1"), "expected less than the radius");
  EXPECT_ERROR(world("Shape \"cylinder\" \"float zmin\" 1"), "no height");
}

// Texture coordinates where a ray from outside towards the origin meets the scene's one quadric, wherever it was put.
vec2 uv_from(const Scene& scene, const vec3& eye) {
  const auto instance = static_cast<std::uint32_t>(scene.instances.size() - 1);
  const Transform to_object = scene.instances[instance].to_world.inverse();
  const Ray ray{.origin = eye, .direction = -eye};
  Hit hit{.instance = instance, .primitive = 0};
  const Quadric& quadric = scene.objects[scene.instances[instance].object].geometry.quadrics.at(0);
  EXPECT_TRUE(intersect_quadric({.origin = to_object.point(eye), .direction = to_object.vector(-eye)}, quadric, infinity, hit.t,
                                hit.uv));
  return scene.surface_at(ray, hit).uv;
}

TEST(PbrtShapes, TexturedQuadricsKeepPbrtsCoordinates) {
  const std::string checks = "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" ";
  // On pbrt's sphere u is the azimuth from x towards y, and v runs from 0 at -z to 1 at +z.
  const float up = std::sin(pi / 4);
  const vec2 plain = uv_from(world(checks + "Shape \"sphere\""), vec3(0, 3 * up, 3 * up));
  EXPECT_NEAR(plain.x, 0.25f, 1e-5f);
  EXPECT_NEAR(plain.y, 0.75f, 1e-5f);
  // Turned by 90 degrees about x, the sphere's y axis lies along the world's z, its z axis along -y.
  const vec2 turned = uv_from(world(checks + "Rotate 90 1 0 0 Shape \"sphere\""), vec3(0, -3 * up, 3 * up));
  EXPECT_NEAR(turned.x, 0.25f, 1e-5f);
  EXPECT_NEAR(turned.y, 0.75f, 1e-5f);
  const vec2 cylinder = uv_from(world(checks + "Rotate 90 0 0 1 Shape \"cylinder\""), vec3(-3, 0, 1.5f));
  EXPECT_NEAR(cylinder.x, 0.25f, 1e-5f);
  EXPECT_NEAR(cylinder.y, 0.75f, 1e-5f);
}

TEST(PbrtShapes, ObjectsAreInstancedByName) {
  const Scene scene = world("ObjectBegin \"o\" Translate 1 0 0 " + triangle +
                            "ObjectEnd\nTranslate 0 5 0 ObjectInstance \"o\" Scale 2 2 2 ObjectInstance \"o\"");
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.objects.size(), 2u);
  EXPECT_TRUE(scene.objects[0].shapes.empty());
  expect_near(scene.instances[1].to_world.point(scene.objects[1].geometry.positions[1]), {2, 5, 0});
  expect_near(scene.instances[2].to_world.point(scene.objects[1].geometry.positions[1]), {4, 5, 0});
  EXPECT_EQ(world("ObjectBegin \"o\" " + triangle + "ObjectEnd").objects.size(), 1u) << "never instanced, left out";
  EXPECT_ERROR(world("ObjectInstance \"o\""), "s.pbrt:3:16: unknown object 'o'");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectInstance \"o\" ObjectEnd"), "instances do not nest");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectBegin \"p\""), "inside another object");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectEnd ObjectBegin \"o\""), "defined twice");
  EXPECT_ERROR(world("ObjectBegin \"o\" AreaLightSource \"diffuse\" " + triangle + "ObjectEnd"), "cannot emit light");
}

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
  EXPECT_ERROR(material_of<Diffuse>("Material \"matte\" \"texture bumpmap\" \"x\""), "'bumpmap' is not supported");
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
  EXPECT_ERROR(world("MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"a\" \"string type\" \"matte\""),
               "defined twice");
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
  EXPECT_GT(material_of<Dielectric>("Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1").alpha, 0.1f);
  EXPECT_FLOAT_EQ(material_of<Dielectric>("Material \"dielectric\" \"float roughness\" .25 \"float eta\" 1.33").alpha, 0.5f);
  EXPECT_FLOAT_EQ(material_of<Dielectric>("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").eta, 1.5168f);
  EXPECT_ERROR(material_of<Dielectric>("Material \"dielectric\" \"spectrum eta\" \"glass-BK8\""),
               "unknown glass 'glass-BK8'; did you mean 'glass-BK7'");
  EXPECT_ERROR(material_of<Dielectric>("Material \"dielectric\" \"float uroughness\" .1"),
               "only conductors may be anisotropic");
  const Plastic coated = material_of<Plastic>(
      "Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float roughness\" 0.09 \"float thickness\" .1 \"integer "
      "maxdepth\" 5");
  EXPECT_FLOAT_EQ(coated.alpha, 0.3f);
  EXPECT_EQ(coated.reflectance.constant, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(material_of<Plastic>("Material \"plastic\"").reflectance.constant, Rgb(0.25f));
  EXPECT_TRUE(warns(world("Material \"plastic\""), "conserves energy"));
  EXPECT_ERROR(material_of<Plastic>("Material \"plastic\" \"rgb Ks\" [1 1 1]"), "'Ks' other than 0.25");
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
  EXPECT_ERROR(reflectance("Texture \"t\" \"float\" \"constant\""), "unknown spectrum texture 't'");
  EXPECT_ERROR(reflectance("Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [2 2 2]"), "above 1");
  EXPECT_ERROR(world("Texture \"t\" \"vector\" \"constant\""), "unknown kind of texture 'vector'");
  EXPECT_ERROR(world("Texture \"t\" \"float\" \"constant\" Texture \"t\" \"float\" \"constant\""), "defined twice");
  EXPECT_FLOAT_EQ(
      material_of<Dielectric>(
          "Texture \"r\" \"float\" \"constant\" \"float value\" .25 Material \"dielectric\" \"texture roughness\" \"r\"")
          .alpha,
      0.5f);
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
  EXPECT_ERROR(world(checks + "\"integer dimension\" 3"), "only 2 is supported");
  EXPECT_ERROR(world(checks + "\"string mapping\" \"spherical\""), "only uv is supported");
  EXPECT_ERROR(world(checks + " Texture \"u\" \"spectrum\" \"mix\" \"texture tex1\" \"t\""),
               "only constants are supported here");
  EXPECT_ERROR(world(checks + " Material \"mirror\" \"texture Kr\" \"t\""), "'Kr' is a texture that varies");
  EXPECT_ERROR(world(checks + " Texture \"u\" \"spectrum\" \"scale\" \"texture tex1\" \"t\" \"texture tex2\" \"t\""),
               "only products with a constant");
}

std::string png_bytes(const std::vector<std::uint8_t>& rgb, ivec2 size) {
  const auto png = encode_png(rgb.data(), size);
  return {png.begin(), png.end()};
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
  EXPECT_ERROR(image("\"string wrap\" \"clamp\""), "only repeat is supported");
  EXPECT_ERROR(image("\"string encoding\" \"gamma 2\""), "expected sRGB or linear");
  EXPECT_ERROR(parse_pbrt("WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"absent.png\"",
                          directory.path("s.pbrt")),
               "s.pbrt:2:35: cannot open");
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
  // pbrt's distant light shines from 'from' towards 'to'.
  const DirectionalLight distant = light_of<DirectionalLight>(
      "Rotate 90 1 0 0 LightSource \"distant\" \"point3 from\" [0 0 0] \"point3 to\" [0 0 5] \"rgb L\" [3 3 3]");
  expect_near(distant.direction, {0, -1, 0});
  expect_near(distant.irradiance, Rgb(3));
  EXPECT_ERROR(light_of<PointLight>("LightSource \"point\" \"float power\" 100"), "'power' is not supported");
  EXPECT_ERROR(light_of<SpotLight>("LightSource \"spot\" \"float coneangle\" 10 \"float conedeltaangle\" 20"),
               "no more than coneangle");
  EXPECT_ERROR(light_of<DirectionalLight>("LightSource \"distant\" \"point3 to\" [0 0 0]"), "has no direction");
  EXPECT_ERROR(light_of<PointLight>("LightSource \"point\" \"rgb I\" [-1 0 0]"), "has the component -1");
  EXPECT_TRUE(warns(world("LightSource \"point\" \"rgb I\" [0 0 0]"), "is black"));
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
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" \"string filename\" \"x.png\""), "'filename' is not supported");
  EXPECT_ERROR(world("AreaLightSource \"diffuse\" \"float power\" 3"), "'power' is not supported");
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
  const Rgb red = kd("[400 .05 580 .05 620 .9 700 .9]");
  EXPECT_GT(red.x, 0.7f);
  EXPECT_LT(red.y, 0.15f);
  EXPECT_LT(red.z, 0.1f);
  expect_near(light_of<PointLight>("LightSource \"point\" \"spectrum I\" \"stdillum-D65\" \"float scale\" 3").intensity,
              Rgb(3));
  EXPECT_NEAR(luminance(light_of<PointLight>("LightSource \"point\" \"spectrum I\" [300 9 900 9]").intensity), 1, 0.01f);
  EXPECT_ERROR(kd("[400 .1 400 .2]"), "wavelengths must increase");
  EXPECT_ERROR(kd("[400 .1 500]"), "pairs of wavelength and value");
  EXPECT_ERROR(kd("\"stdillum-D65\""), "unknown spectrum 'stdillum-D65'");
  const TestDirectory directory;
  directory.write("grey.spd", "# grey\n400 0.3\n700 0.3 # end\n");
  const auto read = [&](const std::string& name) {
    return parse_pbrt("WorldBegin\nMaterial \"matte\" \"spectrum Kd\" \"" + name + "\"" + triangle, directory.path("s.pbrt"));
  };
  expect_near(std::get<Diffuse>(read("grey.spd").materials.at(0)).reflectance.constant, Rgb(0.3f));
  EXPECT_ERROR(read("absent.spd"), "cannot open");
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
  EXPECT_ERROR(load_scene(main), "mesh.ply:2:7: unknown format ''");
  EXPECT_ERROR(world("Include \"absent.pbrt\""), "s.pbrt:3:9: cannot open 'absent.pbrt'");
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
