// A small experiment, run into a folder that is disturbed, and what must hold afterwards.
#pragma once

#include "experiments/log/trust.h"
#include "experiments/report/report.h"
#include "experiments/run/run_directory.h"
#include "framework/core/rng.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/run_results.h"

#include <sys/resource.h>

namespace etendue {

class FaultedRun : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file("tiny.toml",
               "title = \"Tiny\"\nscenes = [\"builtin:furnace\"]\nseeds = 2\nbudget = { samples = 1 }\nresolution = [4, 4]\n"
               "integrators = [\"path\"]\nmetrics = [\"mse\"]\noutputs = { tables = [\"md\"] }\n");
    ASSERT_EQ(run_into("whole").status, 0);
    whole_ = results(log("whole"));
    ASSERT_EQ(whole_.size(), 2u);
  }

  static std::vector<std::string> arguments(const std::string& out) {
    return {"run", "tiny.toml", "--threads", "1", "--out", out};
  }
  Outcome run_into(const std::string& out) { return run(arguments(out)); }
  RunLog log(const std::string& out) { return read_log((directory_ / out / "runs.jsonl").string()); }
  std::filesystem::path path(const std::string& out) const { return directory_ / out; }

  // No cell is done whose files are missing, and no unfinished file is left.
  void expect_honest(const std::string& out, const std::string& what) {
    if (!std::filesystem::exists(path(out))) return;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path(out)))
      EXPECT_NE(entry.path().extension(), ".part") << what << ": " << entry.path();
    if (!std::filesystem::exists(path(out) / "runs.jsonl")) return;
    RunLog left = log(out);
    for (const std::string& finding : distrust(left, path(out).string(), false)) ADD_FAILURE() << what << ": " << finding;
    if (left.finished) {
      EXPECT_EQ(results(left), whole_) << what;
    }
  }
  // The same command mends what was disturbed.
  void expect_mended(const std::string& out, const std::string& what) {
    const Outcome again = run_into(out);
    EXPECT_EQ(again.status, 0) << what << ": " << again.err;
    EXPECT_EQ(results(log(out)), whole_) << what;
    EXPECT_TRUE(log(out).finished) << what;
    expect_honest(out, what);
  }
  void remove(const std::string& out) {
    std::filesystem::remove_all(path(out));
    std::filesystem::remove_all(path("cache"));
  }

  std::map<std::string, std::string> whole_;
};

inline bool sanitized() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#else
  return false;
#endif
}

}  // namespace etendue
