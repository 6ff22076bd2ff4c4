// Too little address space, too large a file, two writers: a clear error or fewer threads, and no abort.
#include "tests/faults/faulted_run.h"

namespace etendue {
namespace {

class Limits : public FaultedRun {
 protected:
  Outcome run_limited(int resource, rlim_t most, const std::vector<std::string>& command) {
    in_child_ = [&] {
      const rlimit limit{most, most};
      setrlimit(static_cast<__rlimit_resource>(resource), &limit);
    };
    const Outcome outcome = run(command);
    in_child_ = {};
    return outcome;
  }
};

TEST_F(Limits, LittleAddressSpaceEndsWithAnErrorAtMost) {
  if (sanitized()) GTEST_SKIP() << "sanitizers take terabytes of address space";
  int done = 0, warned = 0;
  for (const int mebibytes : {128, 144, 160, 192, 256, 384, 512, 768, 1024, 1536, 2048})
    for (const char* threads : {"1", "2", "16"}) {
      const std::string what = fmt::format("{} MiB, {} threads", mebibytes, threads);
      const rlim_t limit = static_cast<rlim_t>(mebibytes) << 20;
      const Outcome render = run_limited(
          RLIMIT_AS, limit,
          {"render", "builtin:cornell-box", "--resolution", "16x16", "--spp", "2", "--threads", threads, "-o", "a.exr"});
      EXPECT_TRUE(render.status == 0 || render.status == 1) << what << " ends with " << render.status << ": " << render.err;
      EXPECT_EQ(render.status == 1, render.err.find("error: ") != std::string::npos) << what << ": " << render.err;
      done += render.status == 0;
      warned += render.err.find("of 16 threads") != std::string::npos;
      const Outcome photons = run_limited(RLIMIT_AS, limit,
                                          {"render", "builtin:cornell-box", "--resolution", "16x16", "--spp", "1", "-i", "sppm",
                                           "--threads", threads, "-o", "a.exr"});
      EXPECT_TRUE(photons.status == 0 || photons.status == 1) << what << " ends with " << photons.status << ": " << photons.err;
    }
  EXPECT_GE(done, 20);
  EXPECT_GE(warned, 1);
}

TEST_F(Limits, TooLargeAFileIsAnErrorThatNamesItAndLeavesNothing) {
  const std::vector<std::string> render{"render", "builtin:cornell-box", "--resolution", "64x64", "--spp", "1", "-o", "a.exr"};
  for (const rlim_t limit : {4096, 16384, 40000}) {
    const Outcome large = run_limited(RLIMIT_FSIZE, limit, render);
    EXPECT_EQ(large.status, 1) << large.err;
    EXPECT_NE(large.err.find("a.exr: cannot be written: File too large"), std::string::npos) << large.err;
    EXPECT_FALSE(std::filesystem::exists(path("a.exr")));
    for (const auto& entry : std::filesystem::directory_iterator(directory_)) EXPECT_NE(entry.path().extension(), ".part");
  }
  for (const rlim_t limit : {300, 700, 1000, 3000, 8000, 20000}) {
    remove("full");
    EXPECT_EQ(run_limited(RLIMIT_FSIZE, limit, arguments("full")).status, 1) << limit;
    expect_honest("full", std::to_string(limit));
    expect_mended("full", std::to_string(limit));
  }
}

TEST_F(Limits, OfTwoWritersOneIsRefusedOrFindsAllDone) {
  for (int time = 0; time < 5; ++time) {
    remove("both");
    const pid_t first = start(arguments("both")), second = start(arguments("both"));
    const int one = finish(first).status, other = finish(second).status;
    EXPECT_TRUE((one == 0 && (other == 0 || other == 2)) || (one == 2 && other == 0)) << one << " and " << other;
    expect_honest("both", "two writers");
    expect_mended("both", "two writers");
  }
}

}  // namespace
}  // namespace etendue
