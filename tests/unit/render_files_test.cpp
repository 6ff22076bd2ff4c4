// The files that `etendue render` writes: nothing is lost, and nothing is replaced that was not meant.
#include "experiments/log/log.h"
#include "framework/io/image/exr.h"
#include "tests/unit/harness_process.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

namespace etendue {
namespace {

class RenderFiles : public ProgramTest {
 protected:
  Outcome render(std::vector<std::string> more) {
    const char* start[] = {"render", "builtin:cornell-box", "--resolution", "8x8",      "--spp", "1", "--threads", "1",
                           "-i",     "irradiance-cache",    "-p",           "samples=4"};
    more.insert(more.begin(), std::begin(start), std::end(start));
    return ProgramTest::run(more);
  }
  void expect_refused(const std::vector<std::string>& more, const std::string& reason) {
    const Outcome refused = render(more);
    EXPECT_EQ(refused.status, 2) << reason;
    EXPECT_NE(refused.err.find(reason), std::string::npos) << refused.err;
  }
};

TEST_F(RenderFiles, WhatIsNoRegularFileIsRefused) {
  const auto fifo = directory_ / "fifo.png";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  std::filesystem::create_directory(directory_ / "directory.png");
  for (const char* name : {"fifo.png", "directory.png"}) {
    expect_refused({"--save-cache", name, "-o", "a.png"},
                   std::string("--save-cache ") + name + ": exists and is not a regular");
    expect_refused({"-o", name}, "is not a regular file");
    expect_refused({"--load-cache", name, "-o", "a.png"}, std::string(name) + ": cannot be read");
  }
  EXPECT_TRUE(std::filesystem::is_fifo(fifo));
  expect_refused({"-o", std::string(300, 'a') + ".png"}, "File name too long");
  expect_refused({"-o", "none/a.png"}, "no directory 'none'");
  expect_refused({"--load-cache", std::string(300, 'a'), "-o", "a.png"}, "cannot be read");
  write_file("text", "no cache at all");
  expect_refused({"--load-cache", "text", "-o", "a.png"}, "text: not a cache");
}

TEST_F(RenderFiles, LimitsThatAreMissedAreToldAsTheyWereGiven) {
  const char* start[] = {"render", "builtin:lambert-sphere", "--resolution", "8x8", "--threads", "1", "-o", "a.png"};
  const auto told = [&](std::vector<std::string> more) {
    more.insert(more.begin(), std::begin(start), std::end(start));
    return ProgramTest::run(more).err;
  };
  EXPECT_NE(told({"--time", "1e-5"}).find(" of 10 us: reading, preparation"), std::string::npos);
  EXPECT_NE(told({"--error", "1e-9", "--spp", "1"}).find("was not reached within 1 iteration and "), std::string::npos);
}

TEST_F(RenderFiles, OneFileForTwoOutputsIsRefused) {
  std::filesystem::create_symlink("a.exr", directory_ / "link");
  expect_refused({"--save-cache", "a.exr", "-o", "a.exr"}, "--save-cache a.exr: the same file as that of -o");
  expect_refused({"--save-cache", "./a.exr", "-o", "a.exr"}, "the same file");
  expect_refused({"--save-cache", "link", "-o", "a.exr"}, "the same file");
  expect_refused({"--save-cache", "a.records.exr", "--aov", "records", "-o", "a.exr"}, "the same file as that of --save-cache");
  EXPECT_FALSE(std::filesystem::exists(directory_ / "a.exr"));
}

// They need no cache and no certain method; a PNG has them beside it as EXR.
TEST_F(RenderFiles, SurfaceImagesAreWrittenForEveryMethod) {
  const auto path = [&](const std::string& aovs, const std::string& output) {
    return ProgramTest::run(
        {"render", "builtin:cornell-box", "--resolution", "8x8", "--spp", "1", "--threads", "1", "--aov", aovs, "-o", output});
  };
  const Outcome first = path("albedo,depth", "a.png"), other = render({"--aov", "depth", "--aov", "records", "-o", "b.exr"});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.out.find("aov         a.albedo.exr\naov         a.depth.exr\n"), std::string::npos) << first.out;
  EXPECT_EQ(other.status, 0) << other.err;
  EXPECT_EQ(read_exr((directory_ / "a.depth.exr").string()).pixels, read_exr((directory_ / "b.depth.exr").string()).pixels);
  expect_refused({"--aov", "normals", "-o", "c.exr"}, "did you mean 'normal'");
  expect_refused({"--aov", "depth,depth", "-o", "c.exr"}, "the same file");
}

TEST_F(RenderFiles, LinksAreFollowedAndNeighboursKept) {
  write_file("old", "old");
  std::filesystem::create_symlink("old", directory_ / "link");
  std::filesystem::create_symlink("new.png", directory_ / "b.png");
  const std::string long_name = std::string(240, 'a') + ".exr";
  for (const char* name : {"link.part", "old.part", "b.png.part", "new.png.part"}) write_file(name, "mine");
  const Outcome done = render({"--save-cache", "link", "--aov", "records", "-o", "b.png"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.out.find("image       b.png\naov         b.records.png\ncache       link\n"), std::string::npos) << done.out;
  EXPECT_TRUE(std::filesystem::is_symlink(directory_ / "link"));
  EXPECT_TRUE(std::filesystem::is_symlink(directory_ / "b.png"));
  EXPECT_TRUE(read_text_file(directory_ / "old").starts_with("etncache"));
  EXPECT_TRUE(std::filesystem::exists(directory_ / "new.png"));
  for (const char* name : {"link.part", "old.part", "b.png.part", "new.png.part"})
    EXPECT_EQ(read_text_file(directory_ / name), "mine") << name;
  const Outcome json = render({"--save-cache", "old", "--aov", "records", "-o", long_name, "--json"});
  EXPECT_EQ(json.status, 0) << json.err;
  EXPECT_NE(json.out.find("\"cache\": \"old\""), std::string::npos) << json.out;
  EXPECT_NE(json.out.find("\"records\": \"aaa"), std::string::npos) << json.out;
  for (const auto& entry : std::filesystem::directory_iterator(directory_))
    EXPECT_FALSE(entry.path().filename().string().starts_with("etendue-")) << entry.path();
}

// It is refused before anything is allocated: an image of 16384 x 16384 takes 20 GiB until it is written, its reference 44 GiB.
TEST_F(RenderFiles, ImagesThatMemoryDoesNotHoldAreRefused) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take terabytes of address space";
#endif
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const rlimit tight{std::min<rlim_t>(before.rlim_max, rlim_t{8} << 30), before.rlim_max};
  const auto film = [](int size) {
    return fmt::format("Film \"rgb\" \"integer xresolution\" {0} \"integer yresolution\" {0}\n", size);
  };
  const std::string rest = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nTranslate 0 0 3\nShape \"sphere\"\n";
  write_file("large.pbrt", film(16384) + rest);
  write_file("larger.pbrt", film(32768) + rest);
  write_file("small.pbrt", film(8) + rest);
  write_file("large.toml",
             "scenes = [\"large.pbrt\", \"larger.pbrt\", \"small.pbrt\"]\nintegrators = [\"path\"]\nbudget = { samples = 1 }\n"
             "reference = { samples = 16 }\n");
  ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);  // which the program inherits
  const Outcome refused = ProgramTest::run({"render", "builtin:furnace", "--resolution", "16384x16384", "-o", "a.exr"});
  const Outcome run = ProgramTest::run({"run", "large.toml", "--threads", "1"});
  setrlimit(RLIMIT_AS, &before);
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_NE(refused.err.find("builtin:furnace at 16384 x 16384 pixels: the image, with the sums it is made of, needs about 20"),
            std::string::npos)
      << refused.err;
  EXPECT_NE(refused.err.find(" are free; expected fewer pixels"), std::string::npos) << refused.err;
  // A scene that is refused fails its cells; the others go on.
  EXPECT_EQ(run.status, 1) << run.err;
  const RunLog log = read_log((directory_ / "out/large/runs.jsonl").string());
  ASSERT_EQ(log.cells.size(), 3u);
  for (const CellRecord& cell : log.cells) {
    const std::string expected =
        cell.cell.scene == "large.pbrt"
            ? "no reference of large.pbrt at 16384 x 16384 pixels: the image, with the sums it is made of, needs about 56"
        : cell.cell.scene == "larger.pbrt"
            ? "no reference of larger.pbrt at 32768 x 32768 pixels: expected 268435456 pixels (16384 x 16384) in all"
            : "";
    EXPECT_EQ(cell.status, expected.empty() ? "done" : "failed") << cell.cell.key();
    EXPECT_TRUE(cell.error.starts_with(expected)) << cell.error;
  }
  EXPECT_EQ(log.references.size(), 1u);
}

TEST_F(RenderFiles, ImagesOfAnyKindAreComparedAndShown) {
  ASSERT_EQ(render({"-o", "a.exr"}).status, 0);
  ASSERT_EQ(render({"-o", "a.png"}).status, 0);
  const auto metrics = [&](const std::string& image, const std::string& reference) {
    return ProgramTest::run({"compare", image, reference, "--difference", "difference.png"});
  };
  EXPECT_EQ(metrics("a.exr", "a.exr").out.find("mse             0\n"), 0u);
  EXPECT_NE(metrics("a.exr", "a.exr").out.find("flip            0\n"), std::string::npos);
  const Outcome seeds = ProgramTest::run({"compare", "a.exr", "a.exr", "--seeds", "a.exr"});
  EXPECT_EQ(seeds.status, 0);
  EXPECT_NE(seeds.out.find("verdict            agrees: a mean ratio off by "), std::string::npos) << seeds.out;
  const Outcome mixed = metrics("a.png", "a.exr");
  EXPECT_EQ(mixed.status, 0) << mixed.err;
  EXPECT_EQ(read_text_file(directory_ / "difference.png").substr(1, 3), "PNG");
  EXPECT_NE(ProgramTest::run({"compare", "a.exr", "a.exr", "--difference", "d.exr"}).err.find("ends in .png"),
            std::string::npos);
}

TEST_F(RenderFiles, BuiltInScenesAreSuggested) {
  const Outcome refused = ProgramTest::run({"render", "cornel-box", "-i", "path", "--spp", "1"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("did you mean 'builtin:cornell-box'?"), std::string::npos) << refused.err;
}

TEST_F(RenderFiles, InspectCountsWhatIsInstanced) {
  write_file("one.pbrt", "WorldBegin\nShape \"sphere\"\nObjectBegin \"o\" Shape \"sphere\" ObjectEnd\nObjectInstance \"o\"\n");
  const Outcome one = ProgramTest::run({"inspect", "one.pbrt"});
  EXPECT_NE(one.out.find("objects       1, instances 1, shapes 2\n"), std::string::npos) << one.out;
  const Outcome none = ProgramTest::run({"inspect", "builtin:cornell-box", "--json"});
  EXPECT_NE(none.out.find("\"instances\": 0,"), std::string::npos) << none.out;
}

// A black image has its reason on stderr, by every command that reads scenes.
TEST_F(RenderFiles, MeshesThatNoRayMeetsAreToldByEveryCommand) {
  write_file("thin.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 1 1 2\n");
  write_file("sound.obj", "v 0 0 0\nv 1 1 1\nv 2 0 2\nf 1 2 3\n");
  write_file("e.toml",
             "title = \"t\"\nscenes = [\"SCENE\"]\nbudget = { samples = 1 }\nresolution = [8, 8]\n"
             "reference = { samples = 16 }\n[[integrators]]\nname = \"path\"\n");
  const std::string experiment = read_text_file(directory_ / "e.toml");
  for (const std::string scene : {"thin.obj", "sound.obj"}) {
    write_file("e.toml", std::string(experiment).replace(experiment.find("SCENE"), 5, scene));
    for (const std::vector<std::string>& command :
         std::vector<std::vector<std::string>>{{"render", scene, "--resolution", "8x8", "--spp", "1", "-o", "a.png"},
                                               {"run", "e.toml", "--fresh"},
                                               {"accel", scene, "--structures", "brute", "--resolution", "8"},
                                               {"inspect", scene, "--json"}}) {
      const Outcome told = ProgramTest::run(command);
      EXPECT_EQ(told.status, 0) << command[0] << told.err;
      const bool warned = told.err.find("warning: thin.obj: all 2 triangles left out") != std::string::npos;
      EXPECT_EQ(warned, scene == "thin.obj") << command[0] << ": " << told.err;
      EXPECT_EQ(told.err.find("left out") != std::string::npos, scene == "thin.obj") << command[0] << ": " << told.err;
    }
  }
}

// Once the render keeps what it has: from then on it ignores closed pipes.
bool ignores_closed_pipes(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("SigIgn:")) return (std::stoull(line.substr(7), nullptr, 16) >> (SIGPIPE - 1) & 1) != 0;
  return false;
}

class InterruptedRender : public ProgramTest {
 protected:
  pid_t start_endless() {
    std::signal(SIGPIPE, SIG_DFL);
    const pid_t pid =
        start({"render", "builtin:furnace", "--resolution", "16x16", "--spp", "1G", "--threads", "1", "-o", "a.exr"});
    for (int i = 0; i < 5000 && !ignores_closed_pipes(pid); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return pid;
  }
};

TEST_F(InterruptedRender, KeepsWhatItHas) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t pid = start_endless();
    kill(pid, signal);
    const Outcome outcome = finish(pid);
    EXPECT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("after this iteration"), std::string::npos) << outcome.err;
    EXPECT_TRUE(std::filesystem::remove(directory_ / "a.exr"));
  }
}

TEST_F(InterruptedRender, OutlivesTheReaderOfItsMessages) {
  const auto pipe = directory_ / "stderr.txt";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  const pid_t pid = start_endless();
  close(reader);
  std::filesystem::remove(pipe);
  kill(pid, SIGINT);
  EXPECT_EQ(finish(pid).status, 130);
  EXPECT_TRUE(std::filesystem::exists(directory_ / "a.exr"));
}

}  // namespace
}  // namespace etendue
