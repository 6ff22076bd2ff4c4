// Finished runs that somebody changed afterwards: no file of a run's folder can be truncated, lose a bit, be taken away or be
// swapped without `run` and `report` noticing.
#include "tests/faults/faulted_run.h"

#include "framework/io/image/exr.h"

#include <sys/stat.h>
#include <algorithm>

namespace etendue {
namespace {

namespace fs = std::filesystem;

class Damage : public FaultedRun {
 protected:
  // All but the lock, which is empty.
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(path("whole")))
      if (entry.is_regular_file() && entry.file_size() > 0) found.push_back(entry.path().lexically_relative(path("whole")));
    std::sort(found.begin(), found.end());
    return found;
  }
  static void put(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

  // Whether a report over the folder says anything.
  bool is_noticed() {
    try {
      const std::string folder = path("whole").string();
      const Report report = write_report({folder}, folder, {{"md"}});
      return !report.findings.empty() || !report.notes.empty();
    } catch (const Error&) {
      return true;
    }
  }

  // Whether a report finds damage in the log and what it names, before it writes anything.
  bool is_found() {
    try {
      const std::string folder = path("whole").string();
      std::vector<RunLog> logs{log("whole")};
      return !missing_parts(logs, {folder}, true).empty() || !distrust(logs[0], folder, true).empty();
    } catch (const Error&) {
      return true;
    }
  }

  // Tries so many lengths and bits of each file; 0: every length.
  void each_damage_is_noticed(std::size_t truncations, std::size_t flips) {
    ASSERT_FALSE(is_noticed());
    std::size_t tried = 0;
    Pcg32 rng(5, 9);
    for (const fs::path& name : files()) {
      const fs::path file = path("whole") / name;
      const std::string whole = read_text_file(file);
      const bool is_named = flips > 100 && (file.extension() == ".jsonl" || file.extension() == ".exr");
      const auto noticed = [&] {
        ++tried;
        return is_named ? is_found() : is_noticed();
      };
      const std::size_t lengths = truncations == 0 ? whole.size() : std::min(truncations, whole.size());
      for (std::size_t i = 0; i < lengths; ++i) {
        const std::size_t length = truncations == 0 ? i : i == 0 ? 0 : i == 1 ? whole.size() - 1 : rng.next() % whole.size();
        put(file, whole.substr(0, length));
        EXPECT_TRUE(noticed()) << name << " cut to " << length << " of " << whole.size() << " bytes";
        put(file, whole);
      }
      for (std::size_t i = 0; i < flips; ++i) {
        std::string flipped = whole;
        const std::size_t bit = i == 0 ? 8 * whole.size() - 8 : rng.next() % (8 * whole.size());
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
        put(file, flipped);
        EXPECT_TRUE(noticed()) << name << ", bit " << bit;
        put(file, whole);
      }
    }
    EXPECT_FALSE(is_noticed()) << "all is as it was";
    RecordProperty("damages", static_cast<int>(tried));
  }
};

TEST_F(Damage, SomeTruncationsAndFlippedBitsOfEveryFileAreNoticed) { each_damage_is_noticed(4, 4); }

class LongDamage : public Damage {};
TEST_F(LongDamage, EveryTruncationOfTheLogAndImagesIsNoticed) {
  for (const fs::path& name : files()) {
    if (name.extension() != ".jsonl" && name.extension() != ".exr") continue;
    const fs::path file = path("whole") / name;
    const std::string whole = read_text_file(file);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      put(file, whole.substr(0, length));
      EXPECT_TRUE(is_found()) << name << " cut to " << length << " of " << whole.size() << " bytes";
    }
    put(file, whole);
  }
}
TEST_F(LongDamage, AThousandFlippedBitsOfEveryFileAreNoticed) { each_damage_is_noticed(100, 1000); }

TEST_F(Damage, RunMendsWhatIsChangedAndSaysSo) {
  Pcg32 rng(3, 1);
  for (const fs::path& name : files()) {
    const fs::path file = path("whole") / name;
    const std::string whole = read_text_file(file);
    std::string flipped = whole;
    flipped[rng.next() % whole.size()] ^= 16;
    const std::string texts[] = {flipped, whole.substr(0, whole.size() / 2)};
    for (const std::string& text : texts) {
      put(file, text);
      const Outcome again = run_into("whole");
      EXPECT_EQ(again.status, 0) << name << again.err;
      EXPECT_NE(again.err.find("warning: "), std::string::npos) << name << again.err;
      EXPECT_EQ(results(log("whole")), whole_) << name;
      const Outcome then = run_into("whole");
      EXPECT_EQ(then.err.find("warning: "), std::string::npos) << name << then.err;
      EXPECT_NE(then.err.find("2 of 2 cells are done already"), std::string::npos) << name << then.err;
    }
  }
  EXPECT_EQ(read_exr((path("whole") / log("whole").cells[0].image).string()).size, ivec2(4));
}

// Its manifest's line holds the number of threads: without it, cells of another number must not be mixed in.
TEST_F(Damage, CellsWhoseManifestIsLostRunAgain) {
  std::string text = read_text_file(path("whole") / "runs.jsonl");
  text[text.find("\"threads\"") + 3] ^= 1;
  put(path("whole") / "runs.jsonl", text);
  const Outcome again = run({"run", "tiny.toml", "--threads", "2", "--out", "whole"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_NE(again.err.find("runs.jsonl:1: bad record: the checksum is wrong"), std::string::npos) << again.err;
  EXPECT_EQ(again.err.find("are done already"), std::string::npos) << again.err;
  EXPECT_EQ(results(log("whole")), whole_);
}

TEST_F(Damage, MissingAndSwappedImagesAreNoticed) {
  const RunLog done = log("whole");
  const fs::path first = path("whole") / done.cells[0].image, second = path("whole") / done.cells[1].image;
  fs::rename(first, path("aside"));
  fs::rename(second, first);
  fs::rename(path("aside"), second);
  const Outcome report = run({"report", "whole"});
  EXPECT_EQ(report.status, 1) << report.err;
  EXPECT_NE(report.err.find("is not as the log says: "), std::string::npos) << report.err;
  EXPECT_NE(run_into("whole").err.find("it runs again"), std::string::npos);
  EXPECT_EQ(run({"report", "whole"}).status, 0);
  fs::remove(first);
  EXPECT_NE(run({"report", "whole"}).err.find("is not as the log says: missing"), std::string::npos);
  EXPECT_EQ(run({"report", "whole", "--logs-only"}).status, 0);
  EXPECT_NE(run_into("whole").err.find("is not as the log says: missing; it runs again"), std::string::npos);
  const fs::path reference = path("whole") / done.references[0].file;
  fs::copy_file(second, reference, fs::copy_options::overwrite_existing);
  const Outcome swapped = run({"report", "whole"});
  EXPECT_EQ(swapped.status, 1);
  EXPECT_NE(swapped.err.find("the reference references/"), std::string::npos) << swapped.err;
  const Outcome again = run_into("whole");
  EXPECT_NE(again.err.find("it is made again"), std::string::npos) << again.err;
  EXPECT_NE(again.err.find("2 of 2 cells are done already"), std::string::npos) << "the same reference: " << again.err;
  EXPECT_EQ(run({"report", "whole"}).status, 0);
}

TEST_F(Damage, GivenReferenceThatChangesIsNoticed) {
  Image given({4, 4});
  for (dvec3& pixel : given.pixels) pixel = dvec3(1);
  write_exr(path("given.exr").string(), given);
  const std::vector<std::string> command{"run",   "tiny.toml", "-o",        "reference.file=given.exr",
                                         "--out", "given",     "--threads", "1"};
  const Outcome first = run(command);
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(run(command).err.find("2 of 2 cells are done already"), std::string::npos);
  for (dvec3& pixel : given.pixels) pixel = dvec3(2);
  write_exr(path("given.exr").string(), given);
  const double before = log("given").checkpoints[0].metrics.at("mse");
  const Outcome again = run(command);
  EXPECT_NE(again.err.find("is not the one that its cells were measured against: they run again"), std::string::npos)
      << again.err;
  EXPECT_NE(log("given").checkpoints[0].metrics.at("mse"), before);
  EXPECT_EQ(run({"report", "given"}).status, 0);
}

TEST_F(Damage, WhatIsNoFileIsRefused) {
  fs::remove(path("whole") / "runs.jsonl");
  ASSERT_EQ(mkfifo((path("whole") / "runs.jsonl").c_str(), 0600), 0);
  for (const auto& command : std::vector<std::vector<std::string>>{arguments("whole"), {"report", "whole"}})
    EXPECT_EQ(run(command).status, 2) << command[0];
}

TEST_F(Damage, LogsOfMissingShardsAreNamed) {
  for (const char* shard : {"0/3", "2/3"})
    ASSERT_EQ(run({"run", "tiny.toml", "-o", "seeds=6", "--threads", "1", "--shard", shard, "--out", shard}).status, 0);
  const Outcome report = run({"report", "0/3", "2/3", "--out", "merged"});
  EXPECT_EQ(report.status, 1);
  EXPECT_NE(report.err.find("shard 1/3 is missing: 4 of 6 cells"), std::string::npos) << report.err;
  EXPECT_TRUE(fs::exists(path("merged/tables/final.md")));
  ASSERT_EQ(run({"run", "tiny.toml", "-o", "seeds=6", "--threads", "1", "--shard", "1/3", "--out", "1/3"}).status, 0);
  EXPECT_EQ(run({"report", "0/3", "1/3", "2/3", "--out", "merged"}).status, 0);
}

// A scene is made of files of its own.
class ChangedScene : public FaultedRun {
 protected:
  void SetUp() override {
    FaultedRun::SetUp();
    write_file("mesh.ply", mesh("3"));
    write_texture(0.5);
    write_file("scene.pbrt", scene("0.5"));
    write_file("mine.toml",
               "scenes = [\"scene.pbrt\", \"builtin:furnace\"]\nbudget = { samples = 1 }\nresolution = [8, 8]\n"
               "integrators = [\"path\"]\nreference = { samples = 64 }\noutputs = { tables = [\"md\"] }\n");
  }
  static std::string mesh(const std::string& height) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n-3 -3 0\n3 -3 0\n0 " +
           height + " 0\n3 0 1 2\n";
  }
  static std::string scene(const std::string& albedo) {
    return "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\nCamera \"perspective\"\nWorldBegin\n"
           "LightSource \"infinite\"\nTranslate 0 0 3\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.exr\"\n"
           "Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n"
           "Material \"diffuse\" \"rgb reflectance\" [" +
           albedo + " 0.5 0.5]\nTranslate 0.5 0 -0.5\nShape \"sphere\"\n";
  }
  void write_texture(double level) {
    Image texture({2, 2});
    for (dvec3& texel : texture.pixels) texel = dvec3(level);
    write_exr(path("t.exr").string(), texture);
  }
  Outcome run_mine() { return run({"run", "mine.toml", "--threads", "1"}); }

  void expect_noticed(const std::string& what) {
    std::string image;
    for (const CellRecord& cell : log("out/mine").cells)
      if (cell.cell.scene == "scene.pbrt") image = (path("out/mine") / cell.image).string();
    const Image before = read_exr(image);
    const Outcome report = run({"report", "out/mine"});
    EXPECT_EQ(report.status, 1) << what << report.err;
    EXPECT_NE(report.err.find("scene.pbrt has changed since"), std::string::npos) << what << report.err;
    const Outcome again = run_mine();
    EXPECT_NE(again.err.find("warning: scene.pbrt has changed since its cells were run"), std::string::npos)
        << what << again.err;
    EXPECT_NE(again.err.find("1 of 2 cells are done already"), std::string::npos) << what << again.err;
    EXPECT_TRUE(read_exr(image).pixels != before.pixels) << what;
    EXPECT_EQ(run({"report", "out/mine"}).status, 0) << what;
    EXPECT_NE(run_mine().err.find("2 of 2 cells are done already"), std::string::npos) << what;
  }
};

TEST_F(ChangedScene, AnotherFilterIsNoChangeOfItsFiles) {
  ASSERT_EQ(run({"run", "mine.toml", "--threads", "1", "--pixel-filter", "triangle"}).status, 0);
  const Outcome report = run({"report", "out/mine"});
  EXPECT_EQ(report.status, 0) << report.err;
  const Outcome again = run_mine();
  EXPECT_NE(again.err.find("scene.pbrt has changed since its cells were run"), std::string::npos) << again.err;
  EXPECT_EQ(run({"report", "out/mine"}).status, 0);
}

TEST_F(ChangedScene, ItsStructuresAreNotBelieved) {
  write_file("structures.toml",
             "scenes = [\"scene.pbrt\"]\naccels = [\"brute\", \"sah\"]\nresolution = [8, 8]\nstructures = true\n"
             "outputs = { tables = [\"md\"] }\n");
  const Outcome made = run({"run", "structures.toml", "--threads", "1"});
  ASSERT_EQ(made.status, 0) << made.err;
  const auto table = [&] { return read_text_file(path("out/structures/tables/structures.md")); };
  EXPECT_NE(table().find("brute"), std::string::npos);
  write_file("mesh.ply", mesh("0.5"));
  const Outcome report = run({"report", "out/structures"});
  EXPECT_EQ(report.status, 1) << report.err;
  EXPECT_NE(report.err.find("2 structures are not believed"), std::string::npos) << report.err;
  EXPECT_FALSE(std::filesystem::exists(path("out/structures/tables/structures.md")));
}

TEST_F(ChangedScene, MeshTextureAndAlbedoAreNoticed) {
  ASSERT_EQ(run_mine().status, 0);
  write_file("mesh.ply", mesh("0.5"));
  expect_noticed("the mesh");
  write_texture(0.25);
  expect_noticed("the texture");
  write_file("scene.pbrt", scene("0.75"));
  expect_noticed("the albedo");
}

TEST_F(ChangedScene, ImagesAreRepeatedToTheBitUnlessItHasChanged) {
  ASSERT_EQ(run_mine().status, 0);
  const std::string image = "out/mine/" + log("out/mine").cells[0].image;
  const Outcome same = run({"render", "--from", image, "-o", "again.exr"});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_NE(same.out.find(", to the bit"), std::string::npos) << same.out;
  EXPECT_TRUE(read_exr(path("again.exr").string()).pixels == read_exr(path(image).string()).pixels);
  std::map<std::string, std::string> attributes, repeated;
  read_exr(path(image).string(), &attributes);
  read_exr(path("again.exr").string(), &repeated);
  for (const char* key : {"scene", "scene_hash", "integrator", "accel", "seed", "resolution", "iterations", "budget", "version",
                          "commit", "manifest"})
    EXPECT_NE(attributes[std::string("etendue_") + key], "") << key;
  for (const char* key : {"scene_hash", "integrator", "accel", "seed", "resolution", "iterations"})
    EXPECT_EQ(attributes[std::string("etendue_") + key], repeated[std::string("etendue_") + key]) << key;
  EXPECT_NE(attributes["etendue_integrator"].find("max_depth="), std::string::npos) << "defaults, too";
  write_file("mesh.ply", mesh("0.5"));
  const Outcome changed = run({"render", "--from", image, "-o", "again.exr"});
  EXPECT_EQ(changed.status, 2);
  EXPECT_NE(changed.err.find("was made of another scene than scene.pbrt is now"), std::string::npos) << changed.err;
}

TEST_F(ChangedScene, EveryMethodsImagesAreRepeated) {
  const std::vector<std::vector<std::string>> methods{{"-i", "sppm", "-p", "photons=500", "--spp", "3"},
                                                      {"-i", "vcm", "--accel", "kd-tree", "--seed", "9"},
                                                      {"-i", "irradiance-cache", "-p", "samples=16", "-p", "accuracy=0.37"},
                                                      {"--time", "50ms", "-p", "max_depth=3"}};
  for (std::vector<std::string> command : methods) {
    command.insert(command.begin(), {"render", "scene.pbrt", "--threads", "2", "-o", "first.exr"});
    ASSERT_EQ(run(command).status, 0) << command[6];
    const Outcome again = run({"render", "--from", "first.exr", "-o", "again.exr"});
    EXPECT_EQ(again.status, 0) << command[6] << again.err;
    EXPECT_TRUE(read_exr(path("again.exr").string()).pixels == read_exr(path("first.exr").string()).pixels) << command[6];
  }
  EXPECT_EQ(run({"render", "--from", "first.exr", "--seed", "3"}).status, 2);
  EXPECT_EQ(run({"render", "--from", "t.exr"}).status, 2) << "an image of others";
  EXPECT_EQ(run({"render"}).status, 2);
}

}  // namespace
}  // namespace etendue
