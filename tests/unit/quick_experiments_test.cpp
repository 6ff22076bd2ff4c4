// `etendue run --quick` of every experiment of this repository: it is done in a minute, and nothing in it fails.
#include "tests/unit/harness_process.h"

#include <sys/resource.h>
#include <algorithm>

namespace etendue {
namespace {

std::vector<std::string> experiments() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(project_folder) + "experiments"))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

class LongQuick : public ProgramTest, public ::testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    begun_ = cpu_of_children();
  }
  // User and system time, which other programs on the machine hardly change.
  static double cpu_of_children() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  double cpu_s() const { return cpu_of_children() - begun_; }

 private:
  double begun_ = 0;
};

// It takes at most a minute of one core, with no reference but those that it brings along or renders.
TEST_P(LongQuick, EndsInAMinuteWithNothingFailed) {
  const std::string path = std::string(project_folder) + "experiments/" + GetParam() + ".toml";
  const Outcome outcome = run({"run", path, "--quick", "--threads", "2", "--out", "out"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_LE(cpu_s(), 60) << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(Long, LongQuick, ::testing::ValuesIn(experiments()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace etendue
