// Mitsuba scenes: where the files lie that a scene with <path> names.
#include "framework/io/load_scene.h"
#include "tests/unit/io_mitsuba_helpers.h"

namespace etendue::mitsuba_test {
namespace {

class MitsubaPaths : public ::testing::Test {
 protected:
  // A spectrum that is the same at all wavelengths.
  void write_grey(const std::string& name, const std::string& value) {
    directory_.write(name, "400 " + value + "\n700 " + value + "\n");
  }
  Scene load(const std::string& inside) { return load_scene(directory_.write("s.xml", scene_text(inside))); }
  static float grey_of(const Scene& scene) { return std::get<Diffuse>(scene.materials.at(0)).reflectance.constant.y; }

  static std::size_t triangles_of(const Scene& scene) { return scene.objects[0].geometry.triangles.size(); }

  const std::string grey_shape_ =
      "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><spectrum name=\"reflectance\" "
      "filename=\"spd/grey.spd\"/></bsdf></shape>";
  TestDirectory directory_;
};

TEST_F(MitsubaPaths, TheLastIsSearchedFirstAndTheScenesFolderLast) {
  const std::string both = "<path value=\"one\"/><path value=\"two\"/>" + grey_shape_;
  EXPECT_ERROR(load(both), "spd/grey.spd");
  write_grey("spd/grey.spd", "0.2");
  directory_.write("one/other", "");
  directory_.write("two/other", "");
  EXPECT_NEAR(grey_of(load(both)), 0.2f, 2e-3f) << "beside the scene";
  write_grey("one/spd/grey.spd", "0.4");
  EXPECT_NEAR(grey_of(load(both)), 0.4f, 2e-3f);
  write_grey("two/spd/grey.spd", "0.6");
  EXPECT_NEAR(grey_of(load(both)), 0.6f, 2e-3f);
  EXPECT_NEAR(grey_of(load(grey_shape_)), 0.2f, 2e-3f) << "without a path";
  // What lies there and is no spectrum is not passed over.
  directory_.write("two/spd/grey.spd", "not a spectrum\n");
  EXPECT_ERROR(load(both), "no spectrum");
}

TEST_F(MitsubaPaths, MeshesAreSearchedForAsWell) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  directory_.write("m.obj", triangle);
  directory_.write("meshes/m.obj", triangle + "v 0 0 1\nf 1 2 4\n");
  const std::string mesh = "<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/></shape>";
  EXPECT_EQ(triangles_of(load(mesh)), 1u);
  EXPECT_EQ(triangles_of(load("<path value=\"meshes\"/>" + mesh)), 2u);
  const Scene missing = load("<path value=\"missing\"/>" + mesh);
  EXPECT_EQ(triangles_of(missing), 1u);
  EXPECT_TRUE(warns(missing, "there is no folder 'missing'"));
}

TEST_F(MitsubaPaths, IncludesAreSearchedForThereToo) {
  directory_.write("parts/shape.xml", scene_text(rectangle));
  EXPECT_ERROR(load("<include filename=\"shape.xml\"/>"), "s.xml:2:");
  EXPECT_EQ(triangles_of(load("<path value=\"parts\"/><include filename=\"shape.xml\"/>")), 2u);
  directory_.write("shape.xml", scene_text(rectangle + rectangle));
  const Scene both = load("<path value=\"parts\"/><include filename=\"shape.xml\"/>");
  EXPECT_EQ(triangles_of(both), 2u);
  EXPECT_TRUE(warns(both, "beside this file as well"));
}

TEST_F(MitsubaPaths, OfAnIncludedFileAreRelativeToIt) {
  directory_.write("parts/paths.xml", scene_text("<path value=\"colours\"/>"));
  write_grey("parts/colours/spd/grey.spd", "0.4");
  EXPECT_NEAR(grey_of(load("<include filename=\"parts/paths.xml\"/>" + grey_shape_)), 0.4f, 2e-3f);
}

TEST_F(MitsubaPaths, AreLimitedInNumber) {
  directory_.write("parts/other", "");
  std::string many;
  for (int i = 0; i < 101; ++i) many += "<path value=\"parts\"/>";
  EXPECT_ERROR(load(many), "more than 100 folders");
}

}  // namespace
}  // namespace etendue::mitsuba_test
