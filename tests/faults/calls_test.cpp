// The k-th open, write, fsync or rename fails, for every k: nothing that is not so is logged, and the same command again ends
// with the results of an undisturbed run.
#include "tests/faults/faulted_run.h"

#include <set>
#include <sstream>

namespace etendue {
namespace {

class FaultyCalls : public FaultedRun {
 protected:
  Outcome run_with(const std::string& fault) {
    in_child_ = [&] {
      setenv("LD_PRELOAD", fault_library, 1);
      setenv("ETENDUE_FAULT_BELOW", "broken", 1);
      setenv("ETENDUE_FAULT_COUNTS", (directory_ / "counts.txt").c_str(), 1);
      setenv("ETENDUE_FAULT_TRACE", (directory_ / "trace.txt").c_str(), 1);
      if (!fault.empty()) setenv("ETENDUE_FAULT", fault.c_str(), 1);
    };
    const Outcome outcome = run_into("broken");
    in_child_ = {};
    return outcome;
  }
  long count(const std::string& kind) {
    std::istringstream counts(read_text_file(directory_ / "counts.txt"));
    std::string name;
    for (long number = 0; counts >> name >> number;)
      if (name == kind) return number;
    return 0;
  }

  // `later_too`: all later calls of the kind fail as well, as on a disk that stays full; every `step`-th is tried.
  void each_fails(const std::string& kind, bool later_too, long step) {
    if (sanitized()) GTEST_SKIP() << "a sanitizer's library wants to be the first";
    remove("broken");
    ASSERT_EQ(run_with("").status, 0);
    const long calls = count(kind);
    EXPECT_GE(calls, 10) << kind;
    long failed = 0;
    for (long k = 1; k <= calls; k += step) {
      remove("broken");
      const std::string fault = kind + ":" + std::to_string(k) + (later_too ? ":on" : "");
      const Outcome broken = run_with(fault);
      EXPECT_TRUE(broken.status >= 0 && broken.status <= 2) << fault << " ends with " << broken.status << ": " << broken.err;
      if (broken.status != 0) {
        ++failed;
        EXPECT_TRUE(broken.err.find("error: ") != std::string::npos || broken.err.find("warning: ") != std::string::npos)
            << fault;
      }
      expect_honest("broken", fault);
      expect_mended("broken", fault);
      if (HasFailure()) return;
    }
    EXPECT_GT(failed, calls / step / 2) << kind;
    RecordProperty(kind, static_cast<int>(calls));
  }
};

TEST_F(FaultyCalls, EachOpenThatFailsIsMended) { each_fails("open", false, 1); }
TEST_F(FaultyCalls, EachWriteThatFailsIsMended) { each_fails("write", false, 1); }
TEST_F(FaultyCalls, EachFlushThatFailsIsMended) { each_fails("fsync", false, 1); }
TEST_F(FaultyCalls, EachRenameThatFailsIsMended) { each_fails("rename", false, 1); }
TEST_F(FaultyCalls, DisksThatStayFullAreMended) {
  each_fails("write", true, 3);
  each_fails("fsync", true, 7);
}

// A power cut asks for this: what a name or a line of the log stands for is on the disk before it.
TEST_F(FaultyCalls, FilesAreOnTheDiskBeforeTheirNamesAndNamesBeforeTheLog) {
  if (sanitized()) GTEST_SKIP() << "a sanitizer's library wants to be the first";
  ASSERT_EQ(run_with("").status, 0);
  std::istringstream trace(read_text_file(directory_ / "trace.txt"));
  std::set<std::string> unflushed;  // files that were written, and folders in which a file took its name
  int renames = 0, appends = 0;
  for (std::string call, file, target; trace >> call >> file;) {
    const bool is_log = file.ends_with("runs.jsonl");
    if (call == "write") {
      if (is_log) {
        ++appends;
        EXPECT_TRUE(unflushed.empty()) << "the log is written while this is not on the disk: " << *unflushed.begin();
      }
      unflushed.insert(file);
    } else if (call == "fsync") {
      unflushed.erase(file);
    } else if (call == "rename") {
      ++renames;
      trace >> target;
      EXPECT_FALSE(unflushed.contains(file)) << target << " names what is not on the disk";
      unflushed.insert(std::filesystem::path(target).parent_path().string());
    }
  }
  EXPECT_TRUE(unflushed.empty()) << *unflushed.begin();
  EXPECT_GE(renames, 9);
  EXPECT_GE(appends, 5);
}

// What a second run repairs is not lost when that, too, is disturbed.
TEST_F(FaultyCalls, RepairsThatFailAreMended) {
  if (sanitized()) GTEST_SKIP() << "a sanitizer's library wants to be the first";
  const auto damage_log = [&] {
    std::string text = read_text_file(path("whole") / "runs.jsonl");
    std::filesystem::copy(path("whole"), path("broken"), std::filesystem::copy_options::recursive);
    text[text.find("\"mse_exponent\"") + 5] ^= 1;
    std::ofstream(path("broken") / "runs.jsonl", std::ios::binary) << text;
  };
  for (const char* kind : {"write", "rename", "fsync"})
    for (int k = 1; k <= 6; ++k) {
      remove("broken");
      damage_log();
      const std::string fault = fmt::format("{}:{}", kind, k);
      EXPECT_EQ(run_with(fault).status, 1) << fault;
      expect_mended("broken", fault);
    }
}

}  // namespace
}  // namespace etendue
