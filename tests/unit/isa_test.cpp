// The instruction set is a choice that changes the time alone: images are the same bits with SSE, AVX2 and AVX-512.
#include "framework/core/isa.h"
#include "experiments/log/log.h"
#include "framework/io/image/exr.h"
#include "tests/unit/harness_process.h"

#include <fmt/format.h>

namespace etendue {
namespace {

class IsaChoice : public ProgramTest {};

TEST_F(IsaChoice, ImagesAreTheSameBitsWithEach) {
  for (const char* method : {"path", "photon-map", "sppm", "vcm", "irradiance-cache"}) {
    SCOPED_TRACE(method);
    std::vector<Image> images;
    for (const Isa isa : supported_isas().subspan(1)) {
      const std::string name(isa_option(isa)), file = name + ".exr";
      const Outcome outcome = run({"render", "builtin:cornell-spheres", "-i", method, "--spp", "2", "--resolution", "24x24",
                                   "--isa", name, "-o", file});
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      images.push_back(read_exr((directory_ / file).string()));
      EXPECT_EQ(images.back().pixels, images.front().pixels) << name;
    }
  }
}

TEST_F(IsaChoice, StandsInTheLogAndInItsTable) {
  write_file(
      "x.toml",
      "scenes = [\"builtin:lambert-sphere\"]\nbudget = { samples = 1 }\nresolution = [8, 8]\nintegrators = [\"path\"]\n");
  ASSERT_EQ(run({"run", "x.toml", "--isa", "sse"}).status, 0);
  const ManifestRecord manifest = read_log((directory_ / "out/x/runs.jsonl").string()).manifests.at(0);
  EXPECT_EQ(manifest.isa, "SSE4.1");
  EXPECT_GT(manifest.cores, 0);
  EXPECT_GT(manifest.memory_bytes, 0u);
  EXPECT_EQ(manifest.date.size(), 10u);
  const std::string table = read_text_file(directory_ / "out/x/tables/manifest.md");
  EXPECT_NE(table.find("SSE4.1"), std::string::npos) << table;
  // The same command goes on where it was, with the manifest that is there.
  ASSERT_EQ(run({"run", "x.toml", "--isa", "sse"}).status, 0);
  EXPECT_EQ(read_log((directory_ / "out/x/runs.jsonl").string()).manifests.size(), 1u);
}

TEST_F(IsaChoice, UnknownNamesAreErrors) {
  const Outcome outcome = run({"render", "builtin:cornell-box", "--isa", "avx3"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("--isa: unknown instruction set 'avx3'"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace etendue
