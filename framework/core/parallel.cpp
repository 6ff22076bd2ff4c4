#include "framework/core/parallel.h"

#include "framework/core/threads.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace etendue {

namespace {

// oneTBB's workers have stacks of 4 MiB; the rest is what a thread is to find free for its work.
constexpr std::size_t probe_stack_bytes = 12 << 20;

struct Gate {
  std::mutex mutex;
  std::condition_variable opened;
  bool open = false;
};

void* wait_at(void* gate_pointer) {
  Gate& gate = *static_cast<Gate*>(gate_pointer);
  std::unique_lock lock(gate.mutex);
  gate.opened.wait(lock, [&] { return gate.open; });
  return nullptr;
}

// How many threads beside this one can live at the same time; `wanted` at most.
int count_startable(int wanted) {
  Gate gate;
  std::vector<pthread_t> threads;
  threads.reserve(static_cast<std::size_t>(wanted));
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return 0;
  pthread_attr_setstacksize(&attributes, probe_stack_bytes);
  for (pthread_t thread; static_cast<int>(threads.size()) < wanted; threads.push_back(thread))
    if (pthread_create(&thread, &attributes, wait_at, &gate) != 0) break;
  pthread_attr_destroy(&attributes);
  {
    const std::lock_guard lock(gate.mutex);
    gate.open = true;
  }
  gate.opened.notify_all();
  for (const pthread_t thread : threads) pthread_join(thread, nullptr);
  return static_cast<int>(threads.size());
}

// Has oneTBB start its workers now, and keep them: each thread waits until all are there, for a while at most.
void start_workers(int threads) {
  std::atomic<int> here = 0;
  const auto late = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        0, threads,
        [&](int) {
          ++here;
          while (here < threads && std::chrono::steady_clock::now() < late) std::this_thread::yield();
        },
        tbb::simple_partitioner());
  });
}

struct StartedThreads {
  std::mutex mutex;
  int count = 1;
  bool is_most = false;  // more were refused
  std::unique_ptr<tbb::global_control> limit;
};

StartedThreads& started_threads() {
  static StartedThreads* const started = new StartedThreads;  // oneTBB may be gone before statics are
  return *started;
}

}  // namespace

int start_threads(int wanted) {
  StartedThreads& started = started_threads();
  const std::lock_guard lock(started.mutex);
  if (wanted > started.count && !started.is_most) {
    const int startable = 1 + count_startable(wanted - 1);
    if (startable < wanted) {
      started.is_most = true;
      started.limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                            static_cast<std::size_t>(startable));
    }
    if (startable > 1) start_workers(startable);
    started.count = startable;
  }
  return std::min(wanted, started.count);
}

void parallel_parts(std::size_t count, std::size_t grain, const void* body,
                    void (*run)(const void* body, std::size_t begin, std::size_t end)) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [=](const tbb::blocked_range<std::size_t>& part) { run(body, part.begin(), part.end()); });
}

void with_threads(int threads, const std::function<void()>& body) {
  threads = start_threads(threads);
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute(body);
}

struct TaskGroup::State {
  tbb::task_group group;
};

TaskGroup::TaskGroup() : state_(std::make_unique<State>()) {}
TaskGroup::~TaskGroup() {
  // Where an exception passes by, tasks may still run, and what they throw as well must not end the process.
  try {
    state_->group.cancel();
    state_->group.wait();
  } catch (...) {
  }
}

void TaskGroup::run(std::function<void()> task) { state_->group.run(std::move(task)); }
void TaskGroup::wait() { state_->group.wait(); }
void TaskGroup::run_and_wait(const std::function<void()>& task) { state_->group.run_and_wait(task); }

int hardware_threads() { return tbb::info::default_concurrency(); }

}  // namespace etendue
