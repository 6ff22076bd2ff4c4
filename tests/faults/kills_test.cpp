// SIGKILL at random times: the same command goes on and ends with the bits of a run that nobody killed.
#include "tests/faults/faulted_run.h"

#include "framework/io/image/exr.h"

namespace etendue {
namespace {

class Kills : public FaultedRun {
 protected:
  void SetUp() override {
    FaultedRun::SetUp();
    write_file("tiny.toml",
               "title = \"Killed\"\nscenes = [\"builtin:furnace\", \"builtin:lambert-sphere\"]\nseeds = 3\n"
               "budget = { samples = 64 }\nresolution = [16, 16]\nintegrators = [\"path\"]\nmetrics = [\"mse\"]\n"
               "outputs = { tables = [\"md\"] }\n");
    remove("whole");
    const auto start = std::chrono::steady_clock::now();
    ASSERT_EQ(run_into("whole").status, 0);
    length_ = std::chrono::steady_clock::now() - start;
    whole_ = results(log("whole"));
  }

  void kill_at_random(int wanted) {
    Pcg32 rng(17, 4);
    int killed = 0, finished = 0;
    for (int attempt = 0; killed < wanted && attempt < 20 * wanted; ++attempt) {
      const pid_t pid = start(arguments("killed"));
      std::this_thread::sleep_for(static_cast<double>(rng.next_float()) * length_);
      kill(pid, SIGKILL);
      const int status = finish(pid).status;
      killed += status == -SIGKILL;
      EXPECT_TRUE(status == -SIGKILL || status == 0) << status;
      if (status != 0 && attempt % 8 != 7) continue;
      // The run goes to its end; the next begins from the start.
      const Outcome last = run_into("killed");
      EXPECT_EQ(last.status, 0) << last.err;
      EXPECT_EQ(results(log("killed")), whole_);
      expect_honest("killed", "killed");
      for (const auto& entry : std::filesystem::directory_iterator(path("whole") / "images"))
        EXPECT_TRUE(read_exr(entry.path().string()).pixels ==
                    read_exr((path("killed") / "images" / entry.path().filename()).string()).pixels);
      remove("killed");
      ++finished;
    }
    EXPECT_EQ(killed, wanted);
    EXPECT_GT(finished, wanted / 20);
  }

  std::chrono::duration<double> length_{};
};

TEST_F(Kills, TwentyAtRandomTimesResumeToTheSameBits) { kill_at_random(20); }

class LongKills : public Kills {};
TEST_F(LongKills, TwoHundredAtRandomTimesResumeToTheSameBits) { kill_at_random(200); }

}  // namespace
}  // namespace etendue
