// `etendue convert`: what it writes where, and what it refuses.
#include "tests/unit/harness_process.h"

namespace etendue {
namespace {

class Convert : public ProgramTest {
 protected:
  void expect_refused(const std::vector<std::string>& arguments, const std::string& reason) {
    const Outcome refused = run(arguments);
    EXPECT_EQ(refused.status, 2) << reason;
    EXPECT_NE(refused.err.find(reason), std::string::npos) << refused.err;
  }
  std::string image_hash(const std::string& scene) {
    const Outcome rendered = run({"render", scene, "--resolution", "8x8", "--spp", "1", "--threads", "1", "--json"});
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    const std::size_t at = rendered.out.find("\"image_hash\"");
    return rendered.out.substr(at, rendered.out.find('\n', at) - at);
  }
};

TEST_F(Convert, WritesASceneThatRendersTheSameBits) {
  std::filesystem::create_directory(directory_ / "there");
  const Outcome done = run({"convert", "builtin:cornell-spheres", "there/box.pbrt"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.out.find("there/box-files"), std::string::npos) << done.out;
  EXPECT_NE(done.err.find("\"mirror\""), std::string::npos) << done.err;  // which is told
  EXPECT_TRUE(std::filesystem::exists(directory_ / "there/box-files/mesh-0.ply"));
  EXPECT_EQ(image_hash("there/box.pbrt"), image_hash("builtin:cornell-spheres"));

  const Outcome again = run({"convert", "there/box.pbrt", "box.pbrt", "--json"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_NE(again.out.find("\"box-files/mesh-0.ply\""), std::string::npos) << again.out;
  for (const char* name : {"box.pbrt", "box-files/mesh-0.ply"})
    EXPECT_EQ(read_text_file(directory_ / name), read_text_file(directory_ / "there" / name)) << name;
}

TEST_F(Convert, TakesMeshesOfAnyKind) {
  write_file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::filesystem::create_directory(directory_ / "b");
  EXPECT_EQ(run({"convert", "a.obj", "a.pbrt"}).status, 0);
  EXPECT_EQ(run({"convert", "a.pbrt", "b/a.pbrt"}).status, 0);
  for (const char* name : {"a.pbrt", "a-files/mesh-0.ply"})
    EXPECT_EQ(read_text_file(directory_ / name), read_text_file(directory_ / "b" / name)) << name;
  EXPECT_EQ(image_hash("a.pbrt"), image_hash("b/a.pbrt"));
}

TEST_F(Convert, RefusesWhatItCannotWrite) {
  expect_refused({"convert", "builtin:cornell-box", "box.obj"}, "expected a name that ends in .pbrt");
  expect_refused({"convert", "builtin:cornell-bocks", "box.pbrt"}, "builtin:cornell-box");
  expect_refused({"convert", "builtin:cornell-box", "none/box.pbrt"}, "no directory 'none'");
  expect_refused({"convert", "builtin:cornell-box"}, "OUT");
  write_file("s.pbrt", "WorldBegin\n");
  std::filesystem::create_symlink("s.pbrt", directory_ / "link.pbrt");
  expect_refused({"convert", "s.pbrt", "link.pbrt"}, "is the scene itself");
  EXPECT_EQ(read_text_file(directory_ / "s.pbrt"), "WorldBegin\n");
  EXPECT_FALSE(std::filesystem::exists(directory_ / "box-files"));
}

}  // namespace
}  // namespace etendue
