// Loops and tasks: each part of the work once, what tasks wrote visible after the wait, exceptions where the caller waits.
#include "framework/core/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace etendue {
namespace {

constexpr int thread_counts[] = {1, 2, 4};

// Plain writes to places of its own by each index: ThreadSanitizer would see two writers, or a reader before the loop's end.
TEST(Parallel, LoopsRunEveryIndexOnceWhateverTheGrain) {
  for (const int threads : thread_counts)
    for (const std::size_t grain : {std::size_t{1}, std::size_t{7}, std::size_t{100000}})
      with_threads(threads, [&] {
        std::vector<int> runs(1000, 0);
        parallel_for(runs.size(), grain, [&](std::size_t i) { ++runs[i]; });
        EXPECT_EQ(std::accumulate(runs.begin(), runs.end(), 0), 1000);
        EXPECT_EQ(*std::max_element(runs.begin(), runs.end()), 1) << threads << " threads, grain " << grain;
        parallel_for(0, grain, [](std::size_t) { FAIL(); });
      });
}

TEST(Parallel, LoopsNest) {
  for (const int threads : thread_counts)
    with_threads(threads, [&] {
      std::vector<std::vector<int>> sums(20, std::vector<int>(50, 0));
      parallel_for(sums.size(), 1, [&](std::size_t i) {
        parallel_for(sums[i].size(), 1, [&, i](std::size_t k) { sums[i][k] = static_cast<int>(i * k); });
        sums[i][0] = std::accumulate(sums[i].begin() + 1, sums[i].end(), 0);
      });
      for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i][0], static_cast<int>(i) * 49 * 50 / 2);
    });
}

TEST(Parallel, LoopsPassExceptionsOn) {
  for (const int threads : thread_counts)
    with_threads(threads, [] {
      EXPECT_THROW(parallel_for(1000, 1,
                                [](std::size_t i) {
                                  if (i == 500) throw std::runtime_error("500");
                                }),
                   std::runtime_error);
    });
}

int tree_sum(const std::vector<int>& values, std::size_t begin, std::size_t end) {
  if (end - begin == 1) return values[begin];
  const std::size_t middle = begin + (end - begin) / 2;
  int left = 0, right = 0;  // written by two tasks
  parallel_invoke([&] { left = tree_sum(values, begin, middle); }, [&] { right = tree_sum(values, middle, end); });
  return left + right;
}

TEST(Parallel, InvokesBothAndNests) {
  std::vector<int> values(500);
  std::iota(values.begin(), values.end(), 1);
  for (const int threads : thread_counts)
    with_threads(threads, [&] { EXPECT_EQ(tree_sum(values, 0, values.size()), 500 * 501 / 2); });
}

// Neither runs any more by then: they may refer to what the caller's frame holds.
TEST(Parallel, InvokeThrowsOnlyOnceBothHaveEnded) {
  for (const int threads : thread_counts)
    with_threads(threads, [] {
      for (int repetition = 0; repetition < 40; ++repetition) {
        std::atomic<int> running{0};
        const auto fails = [] { throw std::runtime_error("one"); };
        const auto lasts = [&] {
          ++running;
          std::this_thread::sleep_for(std::chrono::microseconds(50));
          --running;
        };
        if (repetition % 2 == 0) {
          EXPECT_THROW(parallel_invoke(fails, lasts), std::runtime_error);
        } else {
          EXPECT_THROW(parallel_invoke(lasts, fails), std::runtime_error);
        }
        EXPECT_EQ(running, 0);
      }
    });
}

struct Tree {
  std::vector<int>& visits;
  TaskGroup& tasks;

  void visit(std::size_t node) const {
    ++visits[node];
    for (const std::size_t child : {2 * node + 1, 2 * node + 2})
      if (child < visits.size()) tasks.run([this, child] { visit(child); });
  }
};

// Each task adds those of its children, as the builders of trees do.
TEST(TaskGroup, RunsWhatItsTasksAdd) {
  for (const int threads : thread_counts)
    with_threads(threads, [&] {
      std::vector<int> visits(1023, 0);
      TaskGroup tasks;
      const Tree tree{visits, tasks};
      tasks.run_and_wait([&] { tree.visit(0); });
      EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), 1023);
      EXPECT_EQ(*std::max_element(visits.begin(), visits.end()), 1);
      // It can be used again.
      tasks.run([&] { ++visits[0]; });
      tasks.wait();
      EXPECT_EQ(visits[0], 2);
    });
}

TEST(TaskGroup, WaitThrowsWhatATaskThrew) {
  for (const int threads : thread_counts)
    with_threads(threads, [] {
      TaskGroup tasks;
      for (int i = 0; i < 10; ++i)
        tasks.run([i] {
          if (i == 5) throw std::runtime_error("5");
        });
      EXPECT_THROW(tasks.wait(), std::runtime_error);
    });
}

}  // namespace
}  // namespace etendue
