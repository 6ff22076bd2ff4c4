// `etendue render --crop` and `--camera`: a part of the image has the bits of the whole, and views are those that were asked
// for.
#include "framework/io/image/exr.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

class RenderView : public ProgramTest {
 protected:
  Outcome render(const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> words{"render", scene, "--spp", "2", "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return ProgramTest::run(words);
  }
  Image image(const std::string& name) { return read_exr((directory_ / name).string()); }
  void expect_refused(const std::string& scene, const std::vector<std::string>& more, const std::string& reason) {
    const Outcome refused = render(scene, more);
    EXPECT_EQ(refused.status, 2) << reason;
    EXPECT_NE(refused.err.find(reason), std::string::npos) << refused.err;
  }
};

TEST_F(RenderView, APartHasTheBitsOfTheWholeImage) {
  const std::string box = "builtin:cornell-box";
  for (const std::string method : {"path", "photon-map", "bdpt", "guided", "sppm", "irradiance-cache", "hash-cache"}) {
    const std::vector<std::string> whole{"-i", method, "--resolution", "16x12", "-o", "whole.exr"};
    ASSERT_EQ(render(box, whole).status, 0) << method;
    const Outcome part = render(
        box, {"-i", method, "--resolution", "16x12", "--aov", "depth", "--crop", "0.25", "1", "3", "9", "-o", "part.exr"});
    ASSERT_EQ(part.status, 2) << "pixels and shares are not mixed";
    const Outcome pixels =
        render(box, {"-i", method, "--resolution", "16x12", "--aov", "depth", "--crop", "4", "16", "3", "9", "-o", "part.exr"});
    ASSERT_EQ(pixels.status, 0) << pixels.err;
    const Image all = image("whole.exr"), cut = image("part.exr");
    ASSERT_EQ(cut.size, ivec2(12, 6));
    EXPECT_EQ(image("part.depth.exr").size, cut.size);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 12; ++x) EXPECT_EQ(cut.at(x, y), all.at(x + 4, y + 3)) << method << " " << x << " " << y;
    ASSERT_EQ(
        render(box, {"-i", method, "--resolution", "16x12", "--crop", "0.25", "1", "0.25", "0.75", "-o", "share.exr"}).status,
        0);
    EXPECT_EQ(image("share.exr").pixels, cut.pixels) << method;
  }
  const Outcome again = ProgramTest::run({"render", "--from", "part.exr", "-o", "again.exr"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(image("again.exr").pixels, image("part.exr").pixels);
}

TEST_F(RenderView, APartIsCheckedAndTakenFromTheFile) {
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{"0.5", "0.5", "0", "1"}, {"0.6", "0.5", "0", "1"}, {"0", "17", "0", "16"}}) {
    std::vector<std::string> more{"--resolution", "16x16", "-o", "a.exr", "--crop"};
    more.insert(more.end(), wrong.begin(), wrong.end());
    expect_refused("builtin:cornell-box", more, "is no part of 16 x 16 pixels");
  }
  expect_refused("builtin:cornell-box", {"--crop", "0", "1", "0", "0.5", "--error", "1"}, "--error takes the whole image");
  write_file("part.pbrt",
             "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 8 \"float cropwindow\" [0.5 1 0 0.5]\n"
             "WorldBegin\nLightSource \"infinite\"\n");
  ASSERT_EQ(render("part.pbrt", {"-o", "part.exr"}).status, 0);
  EXPECT_EQ(image("part.exr").size, ivec2(8, 4));
  ASSERT_EQ(render("part.pbrt", {"--crop", "0", "1", "0", "1", "-o", "all.exr"}).status, 0);
  EXPECT_EQ(image("all.exr").size, ivec2(16, 8));
}

TEST_F(RenderView, CamerasAreNamedOrTyped) {
  const std::string mesh = "<emitter type=\"constant\"/><shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>";
  const auto sensor = [](const std::string& id, const std::string& from) {
    return "<sensor type=\"perspective\" id=\"" + id +
           "\"><float name=\"fov\" value=\"40\"/><transform name=\"to_world\"><lookat origin=\"" + from +
           "\" target=\"0,0,0\" up=\"0,1,0\"/></transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"16\"/>"
           "<integer name=\"height\" value=\"16\"/></film></sensor>";
  };
  write_file("s.xml", "<scene version=\"3.0.0\">" + sensor("front", "0,0,5") + sensor("side", "9,1,0") + mesh + "</scene>");
  ASSERT_EQ(render("s.xml", {"--camera", "side", "-o", "side.exr"}).status, 0);
  const Outcome typed = render("s.xml", {"--camera", "9,1,0 0,0,0 40", "-o", "typed.exr"});
  ASSERT_EQ(typed.status, 0) << typed.err;
  const Image side = image("side.exr"), same = image("typed.exr");
  double difference = 0;
  for (std::size_t i = 0; i < side.pixels.size(); ++i) difference += std::abs(side.pixels[i].y - same.pixels[i].y);
  EXPECT_LT(difference / static_cast<double>(side.pixels.size()), 0.02) << "another rounding of the same view";
  ASSERT_EQ(render("s.xml", {"-o", "front.exr"}).status, 0);
  EXPECT_NE(image("front.exr").pixels, side.pixels);
  const Outcome again = ProgramTest::run({"render", "--from", "typed.exr", "-o", "again.exr"});
  EXPECT_EQ(again.status, 0) << again.err;
  expect_refused("s.xml", {"--camera", "sidee"}, "unknown camera 'sidee'; did you mean 'side'");
  expect_refused("s.xml", {"--camera", "1,2,3 1,2,3"}, "eye and target coincide");
  expect_refused("s.xml", {"--camera", "1e30,2,3 1,2,3"}, "the eye lies beyond 1e+12 m");
  expect_refused("builtin:cornell-box", {"--camera", "1,2 3"}, "expected the name of a camera of the file");
}

// Seen from outside, the formula of a sphere's inside has no value.
TEST_F(RenderView, AClosedFormIsOfTheScenesOwnViewAlone) {
  const std::vector<std::string> small{"-i", "path", "--resolution", "8x8"};
  EXPECT_NE(render("builtin:lambert-sphere", small).out.find("relmse"), std::string::npos);
  std::vector<std::string> outside = small;
  outside.insert(outside.end(), {"--camera", "0,0,-5 0,0,0 40"});
  const Outcome told = render("builtin:lambert-sphere", outside);
  EXPECT_EQ(told.status, 0) << told.err;
  EXPECT_EQ(told.out.find("relmse"), std::string::npos) << told.out;
  EXPECT_EQ(told.out.find("nan"), std::string::npos) << told.out;
  EXPECT_NE(told.err.find("holds for the scene's own view"), std::string::npos) << told.err;
}

TEST_F(RenderView, FiltersGiveWayToTheOption) {
  write_file("s.pbrt",
             "PixelFilter \"gaussian\"\nFilm \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n"
             "WorldBegin\nLightSource \"infinite\"\nTranslate 0 0 5 Shape \"sphere\"\n");
  ASSERT_EQ(render("s.pbrt", {"-o", "own.exr"}).status, 0);
  const Outcome box = render("s.pbrt", {"--pixel-filter", "box", "-o", "box.exr"});
  ASSERT_EQ(box.status, 0) << box.err;
  EXPECT_NE(image("own.exr").pixels, image("box.exr").pixels);
  EXPECT_EQ(ProgramTest::run({"render", "--from", "box.exr", "-o", "again.exr"}).status, 0);
  expect_refused("s.pbrt", {"--pixel-filter", "boxx"}, "--pixel-filter: unknown pixel filter 'boxx'; did you mean 'box'");
}

}  // namespace
}  // namespace etendue
