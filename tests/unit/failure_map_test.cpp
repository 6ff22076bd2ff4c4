// Cells of the failure map that defects of photon maps and caches move: tests/mutation has them. Each is swept from the
// experiment's own file, with fewer seeds and coarser steps.
#include "experiments/kinds/stress/stress_report.h"
#include "tests/places.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>

namespace etendue {
namespace {

struct ExpectedCell {
  const char *cell, *trial;
  Holding holding;
  double low = 0, high = 0;  // of the threshold
};

class LongFailureMap : public ProgramTest, public ::testing::WithParamInterface<ExpectedCell> {};

TEST_P(LongFailureMap, CellStands) {
  const ExpectedCell& expected = GetParam();
  const Outcome outcome =
      run({"run", std::string(project_folder) + "experiments/stress.toml", "--out", "out", "-o", "seeds=2", "-o",
           "sweep.factor=1.6", "--filter", std::string(expected.cell) + " \\| " + expected.trial + " \\|"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const RunLog log = read_log((directory_ / "out/runs.jsonl").string());
  const auto records = done_records_of<StressRecord>(log);
  ASSERT_EQ(records.size(), 1u);
  const Threshold found = threshold_of(records[0]->curve(), records[0]->holds);
  EXPECT_EQ(found.holding, expected.holding) << outcome.out;
  if (expected.holding != Holding::up_to) return;
  const double x = records[0]->range.at(found.t);
  EXPECT_LE(expected.low, x);
  EXPECT_LE(x, expected.high);
}

INSTANTIATE_TEST_SUITE_P(Cells, LongFailureMap,
                         ::testing::Values(ExpectedCell{"stress-01", "photon-map", Holding::up_to, 0.09, 0.11},
                                           ExpectedCell{"stress-01", "photon-map: side test", Holding::to_the_end},
                                           ExpectedCell{"stress-02", "photon-map: visible domain", Holding::to_the_end},
                                           ExpectedCell{"stress-03", "photon-map", Holding::up_to, 0.2, 0.25},
                                           ExpectedCell{"stress-06", "sppm", Holding::up_to, 0.25, 0.5},
                                           ExpectedCell{"stress-10", "irradiance-cache: neighbour clamping",
                                                        Holding::to_the_end}),
                         [](const auto& cell) {
                           std::string name = std::string(cell.param.cell) + "_" + cell.param.trial;
                           std::ranges::replace_if(
                               name, [](unsigned char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace
}  // namespace etendue
