// The matrix: its order, filters and shards.
#include "experiments/config/cells.h"
#include "experiments/config/config_tree.h"
#include "experiments/kind.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstdlib>
#include <set>

namespace etendue {
namespace {

ExperimentConfig small_matrix() {
  ExperimentConfig config;
  config.kind = &kind_of(parse_config("scenes = []", "images.toml"));
  config.scenes = {{"s1", "s1", {}}, {"s2", "s2", {}}};
  config.accels = {{"a", {}, {}}};
  config.integrators = {{"p", {}, {}}, {"q", {}, {}}};
  config.seeds = {1, 2, 3};
  return config;
}

TEST(Cells, MethodsAlternateAndSeedsAreOutermost) {
  const auto cells = make_cells(small_matrix());
  ASSERT_EQ(cells.size(), 12u);
  EXPECT_EQ(cells[0].name.key(), "s1 | a | p | seed=1");
  EXPECT_EQ(cells[1].name.key(), "s1 | a | q | seed=1");
  EXPECT_EQ(cells[2].name.key(), "s2 | a | p | seed=1");
  EXPECT_EQ(cells[4].name.key(), "s1 | a | p | seed=2");
}

TEST(Cells, FilterFindsInTheKey) {
  const auto cells = make_cells(small_matrix());
  EXPECT_EQ(filter_cells(cells, "s2 .* q .*seed=[12]$").size(), 2u);
  EXPECT_THROW(filter_cells(cells, "("), Error);
  EXPECT_THROW(filter_cells(cells, "nothing"), Error);
  EXPECT_THROW(filter_cells(cells, std::string(100'000, 'x')), Error);
  EXPECT_THROW(filter_cells(cells, "(.*)*(.*)*(.*)*(.*)*$x"), Error);  // takes for ever where it is matched by backtracking
}

TEST(Cells, FilterSaysThatBackReferencesAreNotSupported) {
  try {
    filter_cells(make_cells(small_matrix()), "(s).*\\1");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("back-references are not supported"), std::string::npos) << e.what();
  }
}

TEST(Shards, EveryPositionIsInExactlyOneOfEvenSize) {
  for (const int count : {1, 2, 3, 4, 7, 12, 20}) {
    std::vector<std::size_t> sizes(static_cast<std::size_t>(count), 0);
    for (std::size_t position = 0; position < 41; ++position) {
      int owners = 0;
      for (int index = 0; index < count; ++index)
        if (in_shard(position, {index, count})) {
          ++owners;
          ++sizes[static_cast<std::size_t>(index)];
        }
      EXPECT_EQ(owners, 1);
    }
    EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()) - *std::min_element(sizes.begin(), sizes.end()), 1u);
  }
}

TEST(Shards, CountThatDividesTheMethodsStillMixesThem) {
  const auto cells = make_cells(small_matrix());
  for (int index = 0; index < 2; ++index) {
    std::set<std::size_t> methods;
    for (const Cell& cell : shard_cells(cells, {index, 2})) methods.insert(cell.integrator);
    EXPECT_EQ(methods.size(), 2u);
  }
}

TEST(Shards, TextIsChecked) {
  EXPECT_EQ(Shard::parse("2/5").index, 2);
  EXPECT_EQ(Shard::parse("2/5").count, 5);
  for (const char* bad : {"5/5", "-1/5", "1", "a/b", "1/0", "1/2/3", "", "/"}) EXPECT_THROW(Shard::parse(bad), Error) << bad;
}

class SlurmArray {
 public:
  SlurmArray(const char* id, const char* lowest, const char* step, const char* count) {
    setenv("SLURM_ARRAY_TASK_ID", id, 1);
    setenv("SLURM_ARRAY_TASK_MIN", lowest, 1);
    setenv("SLURM_ARRAY_TASK_STEP", step, 1);
    setenv("SLURM_ARRAY_TASK_COUNT", count, 1);
  }
  ~SlurmArray() {
    for (const char* name : {"ID", "MIN", "STEP", "COUNT"}) unsetenv((std::string("SLURM_ARRAY_TASK_") + name).c_str());
  }
};

TEST(Shards, SlurmArrayGivesIndexAndCount) {
  const auto outside = Shard::from_slurm();
  EXPECT_FALSE(outside.has_value());
  EXPECT_THROW(Shard::parse("slurm"), Error);
  const SlurmArray array("14", "10", "2", "4");
  EXPECT_EQ(Shard::parse("slurm").index, 2);
  EXPECT_EQ(Shard::parse("slurm").count, 4);
}

TEST(Shards, UnevenSlurmArrayIsRefused) {
  const SlurmArray array("7", "1", "1", "3");  // --array=1,5,7
  EXPECT_THROW(Shard::from_slurm(), Error);
}

}  // namespace
}  // namespace etendue
