// Which files a scene may name: kinds, places, amounts; and what messages show of them.
#include "framework/core/memory.h"
#include "framework/io/load_scene.h"
#include "framework/io/text.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <chrono>

namespace etendue {
namespace {

namespace fs = std::filesystem;

const std::string before = "Camera \"perspective\"\nWorldBegin\n";
const std::string small_ply =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n";

// The ways in which a scene names a file, with the place of the name in s.pbrt.
std::vector<std::pair<std::string, std::string>> directives_naming(const std::string& file) {
  return {{"Include \"" + file + "\"\n", ":3:9: "},
          {"Import \"" + file + "\"\n", ":3:8: "},
          {"Shape \"plymesh\" \"string filename\" \"" + file + "\"\n", ":3:17: "},
          {"Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + file + "\"\n", ":3:35: "},
          {"LightSource \"infinite\" \"string mapname\" \"" + file + "\"\n", ":3:24: "}};
}

TEST(SceneFiles, WhatIsNoRegularFileIsRefusedAtOnce) {
  const TestDirectory directory;
  ASSERT_EQ(::mkfifo(directory.path("fifo").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo(directory.path("fifo.spd").c_str(), 0600), 0);
  fs::create_directory(directory.path("folder"));
  fs::create_symlink("fifo", directory.path("link"));
  const auto begin = std::chrono::steady_clock::now();
  const std::pair<std::string, std::string> files[] = {
      {"fifo", "it is a FIFO"}, {"link", "it is a FIFO"}, {"folder", "it is a directory"}, {"/dev/zero", "it is a device"}};
  for (const auto& [file, what] : files)
    for (const auto& [directive, where] : directives_naming(file)) {
      const std::string message = error_of([&] { (void)read_pbrt(directory.write("s.pbrt", before + directive)); });
      EXPECT_TRUE(contains(message, what)) << directive;
      EXPECT_TRUE(contains(message, "s.pbrt" + where)) << directive;
    }
  EXPECT_ERROR(read_pbrt(directory.write("s.pbrt", before + "LightSource \"point\" \"spectrum I\" \"fifo.spd\"\n")),
               "it is a FIFO; expected a regular file");
  for (const char* name : {"s.pbrt", "s.obj", "s.smf", "s.ply"}) {
    fs::remove(directory.path(name));
    ASSERT_EQ(::mkfifo(directory.path(name).c_str(), 0600), 0);
    EXPECT_ERROR(load_scene(directory.path(name)), "it is a FIFO; expected a regular file");
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(SceneFiles, BackslashesAreSlashesWhereNoFileHasThem) {
  const TestDirectory directory;
  fs::create_directory(directory.path("meshes"));
  directory.write("meshes/mesh.ply", small_ply);
  const std::string scene = directory.write(
      "s.xml",
      "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"meshes\\mesh.ply\"/></shape></scene>");
  EXPECT_EQ(load_scene(scene).objects.at(0).geometry.triangles.size(), 1u);
  fs::remove(directory.path("meshes/mesh.ply"));
  EXPECT_ERROR(load_scene(scene), "meshes/mesh.ply");
}

TEST(SceneFiles, FilesLargerThanTheMemoryAreRefused) {
  const TestDirectory directory;
  directory.write("huge.ply", "ply\n");
  fs::resize_file(directory.path("huge.ply"), std::uintmax_t{1} << 42);  // a hole
  EXPECT_ERROR(read_pbrt(directory.write("s.pbrt", before + "Shape \"plymesh\" \"string filename\" \"huge.ply\"\n")),
               "needs about 4096 GiB");
}

// pbrt looks in the folder of the file it was given.
// Texels of 48 MiB, eight times; the file has 64 KiB.
TEST(SceneFiles, CopiesOfTexturesLargerThanTheMemoryAreRefused) {
  const TestDirectory directory;
  std::string runs("\0\0\x0b\0\0\0\0\0\0\0\0\0\0\x08\0\x08\x08\0", 18);
  for (int run = 0; run < 2048 * 2048 / 128; ++run) runs += std::string("\xff\x80", 2);
  directory.write("i.tga", runs);
  std::string text = before + "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"i.tga\"\n";
  for (int copy = 0; copy < 8; ++copy)
    text += "Texture \"" + std::to_string(copy) + "\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"float scale\" 0.5\n";
  directory.write("s.pbrt", text);
  set_memory_limit(resident_memory_bytes() + (std::uint64_t{256} << 20));
  EXPECT_ERROR(read_pbrt(directory.path("s.pbrt")), "'i.tga' needs about 48");
  set_memory_limit(0);
}

TEST(SceneFiles, NamesInIncludedPbrtFilesAreThoseOfTheFirstFolder) {
  const TestDirectory directory;
  directory.write("a.pbrt", "LightSource \"point\" \"rgb I\" [1 1 1]");
  directory.write("parts/a.pbrt", "LightSource \"point\" \"rgb I\" [2 2 2]");
  directory.write("parts/b.pbrt", "LightSource \"point\" \"rgb I\" [3 3 3]");
  directory.write("parts/both.pbrt", "Include \"a.pbrt\" Include \"b.pbrt\"");
  const Scene scene = read_pbrt(directory.write("s.pbrt", "WorldBegin Include \"parts/both.pbrt\""));
  EXPECT_EQ(std::get<PointLight>(scene.lights.at(0)).intensity, Rgb(1));
  EXPECT_EQ(std::get<PointLight>(scene.lights.at(1)).intensity, Rgb(3)) << "where it is not there, beside the including file";
}

TEST(SceneFiles, IncludesAreCountedAndMeasured) {
  const TestDirectory directory;
  // Each file includes the next one twice: 2^30 includes.
  for (int i = 0; i < 30; ++i) {
    const std::string next = "Include \"b" + std::to_string(i + 1) + ".pbrt\"\n";
    directory.write("b" + std::to_string(i) + ".pbrt", next + next);
  }
  directory.write("b30.pbrt", triangle);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_ERROR(read_pbrt(directory.write("s.pbrt", before + "Include \"b0.pbrt\"\n")),
               "b28.pbrt:2:9: the scene includes more than 10000 files");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));

  EXPECT_ERROR(read_pbrt(directory.write("self.pbrt", before + "Include \"self2.pbrt\"\n")), "self2.pbrt': No such file");
  directory.write("self2.pbrt", "Include \"self2.pbrt\"\n");
  EXPECT_ERROR(read_pbrt(directory.path("self.pbrt")), "self2.pbrt:1:9: files include each other more than 32 deep");

  directory.write("comment.pbrt", std::string(std::size_t{32} << 20, '#'));
  std::string many = before;
  for (int i = 0; i < 33; ++i) many += "Include \"comment.pbrt\"\n";
  EXPECT_ERROR(read_pbrt(directory.write("many.pbrt", many)), "many.pbrt:35:9: the scene includes more than 1024 MiB");
}

TEST(SceneFiles, FilesOutsideTheFolderAreToldOrRefused) {
  const TestDirectory directory;
  directory.write("outside/m.ply", small_ply);
  directory.write("scene/below/m.ply", small_ply);
  const auto scene = [&](const std::string& file) {
    return directory.write("scene/s.pbrt", before + "Shape \"plymesh\" \"string filename\" \"" + file + "\"\n");
  };
  const SceneReading confined{.confined = true};
  EXPECT_FALSE(warns(read_pbrt(scene("below/m.ply"), confined), "outside"));
  EXPECT_FALSE(warns(read_pbrt(scene("below/../below/m.ply"), confined), "outside"));
  EXPECT_FALSE(warns(read_pbrt(scene(directory.path("scene/below/m.ply")), confined), "outside")) << "absolute, but inside";

  fs::create_symlink("../outside/m.ply", directory.path("scene/link.ply"));
  fs::create_directory_symlink("../outside", directory.path("scene/folder"));
  for (const std::string file : {"../outside/m.ply", "link.ply", "folder/m.ply", "below/../../outside/m.ply"}) {
    EXPECT_TRUE(warns(read_pbrt(scene(file)), "s.pbrt:3:17: '" + file + "' lies outside the folder of the scene")) << file;
    EXPECT_ERROR(load_scene(scene(file), {}, confined),
                 "s.pbrt:3:17: '" + file + "' lies outside the folder of the scene; --confined allows only");
  }
  directory.write("outside/grey.spd", "400 0.3\n700 0.3\n");
  const std::string spectrum = directory.write("scene/spectrum.pbrt", before +
                                                                          "Material \"diffuse\" \"spectrum reflectance\" "
                                                                          "\"../outside/grey.spd\"\n");
  EXPECT_TRUE(warns(read_pbrt(spectrum), "spectrum.pbrt:3:20: '../outside/grey.spd' lies outside"));
  EXPECT_ERROR(read_pbrt(scene("../outside/absent.ply"), confined), "lies outside") << "nor is it said what exists there";

  std::string many = before;
  for (int i = 0; i < 14; ++i) {
    const std::string file = "outside/" + std::to_string(i) + ".ply";
    directory.write(file, small_ply);
    many += "Shape \"plymesh\" \"string filename\" \"../" + file + "\"\n";
  }
  const Scene told = read_pbrt(directory.write("scene/many.pbrt", many));
  EXPECT_TRUE(warns(told, "'../outside/9.ply' lies outside"));
  EXPECT_FALSE(warns(told, "'../outside/10.ply' lies outside"));
  EXPECT_TRUE(warns(told, "4 more files lie outside"));
}

// A message may go to someone who may not read the file.
TEST(SceneFiles, ContentsOfWhatIsNoSceneAreNotShown) {
  const TestDirectory directory;
  const std::string secrets[] = {"topsecret:x:0:0:topsecret:/topsecret:/bin/sh\n",
                                 "Scale topsecret topsecret\n",
                                 "Identity topsecret\n",
                                 "\"topsecret\" topsecret\n",
                                 "12topsecret topsecret\n",
                                 "[topsecret]\n",
                                 "$6$topsecret\n",
                                 "# topsecret\ntopsecret",
                                 "\"topsecret",
                                 "topsecret = topsecret\n",
                                 "ply topsecret\n",
                                 "ply\ntopsecret\n",
                                 "ply\nformat topsecret\n",
                                 "#?RADIANCE topsecret\ntopsecret\n\n-Y topsecret\n",
                                 "f topsecret\n",
                                 "v topsecret\n",
                                 "topsecret\n"};
  int refused = 0;
  for (const std::string& secret : secrets) {
    directory.write("secret", secret);
    directory.write("secret.spd", secret);
    const auto expect_nothing_shown = [&](const std::string& message) {
      if (!message.empty()) ++refused;
      EXPECT_EQ(message.find("topsecret"), std::string::npos) << message;
    };
    auto directives = directives_naming("secret");
    directives.emplace_back("LightSource \"point\" \"spectrum I\" \"secret.spd\"\n", "");
    for (const auto& [directive, where] : directives)
      expect_nothing_shown(error_of([&] { (void)read_pbrt(directory.write("s.pbrt", before + directive)); }));
    for (const char* extension : {"pbrt", "obj", "smf", "ply"})
      expect_nothing_shown(error_of([&] { (void)load_scene(directory.write(std::string("named.") + extension, secret)); }));
  }
  EXPECT_GT(refused, 150);
}

TEST(SceneFiles, MistakesInGenuineScenesAreShown) {
  const TestDirectory directory;
  directory.write("part.pbrt", "Scale 1 1 1\nShap \"sphere\"\n");
  EXPECT_ERROR(read_pbrt(directory.write("s.pbrt", before + "Include \"part.pbrt\"\n")),
               "part.pbrt:2:1: unknown directive 'Shap'; did you mean 'Shape'");
  EXPECT_ERROR(parse_pbrt("Camra \"perspective\"\n", "s.pbrt"), "s.pbrt:1:1: no pbrt scene");
  EXPECT_ERROR(parse_pbrt("Camra \"perspective\"\n", "s.pbrt"), "did you mean 'Camera'?");
  EXPECT_ERROR(parse_pbrt("Scale 1 1 x\n", "s.pbrt"), "s.pbrt:1:11: Scale: expected a number, found 'x'");
}

TEST(SceneFiles, WhatIsNotFiniteIsListed) {
  const TestDirectory directory;
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 14\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
      "property float ny\nproperty float nz\nproperty float u\nproperty float v\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 14; ++i)
    ply += std::to_string(i % 3) + " " + std::to_string(i * i) + " 0 " + (i > 1 ? "nan" : "0") + " 0 1 " +
           (i == 3 ? "inf" : "0") + " 0\n";
  directory.write("m.ply", ply + "3 0 1 2\n");
  const Scene scene = read_pbrt(directory.write("s.pbrt", before + "Shape \"plymesh\" \"string filename\" \"m.ply\"\n"));
  EXPECT_TRUE(warns(scene, "s.pbrt:3:1: ")) << "names the place";
  EXPECT_TRUE(warns(scene,
                    "NaN or infinity in the normals (replaced by those of the faces) of 12 vertices, counted from 0: "
                    "2, 3, 4, 5, 6, 7, 8, 9, 10, 11, ..."));
  EXPECT_TRUE(warns(scene, "texture coordinates (taken as 0) of 1 vertices, counted from 0: 3"));
  EXPECT_TRUE(warns(load_scene(directory.path("m.ply")), "of 12 vertices"));
}

}  // namespace
}  // namespace etendue
