// The part of oneTBB that this project uses, by the standard library's threads: the preset `tsan` puts it in oneTBB's place,
// since ThreadSanitizer does not see what comes before what inside a library that is not built for it, and would take every
// loop for a race. It is there to find races, not to be fast: each loop begins a few threads, and where none is spare the work
// is done at once. Its own counters are relaxed: an order that they made between threads would hide the races of what these do.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tbb {

class task_group {
 public:
  task_group() = default;
  ~task_group() { join(); }
  task_group(const task_group&) = delete;
  task_group& operator=(const task_group&) = delete;

  template <class Work>
  void run(Work work) {
    if (spare().fetch_sub(1, std::memory_order_relaxed) <= 0) {
      spare().fetch_add(1, std::memory_order_relaxed);
      return attempt(work);
    }
    const std::lock_guard lock(mutex_);
    threads_.emplace_back([this, work = std::move(work)] {
      attempt(work);
      spare().fetch_add(1, std::memory_order_relaxed);
    });
  }
  void wait() {
    join();
    const std::lock_guard lock(mutex_);
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
  }
  template <class Work>
  void run_and_wait(const Work& work) {
    attempt(work);
    wait();
  }

 private:
  static std::atomic<int>& spare() {
    static std::atomic<int> spare{3};
    return spare;
  }
  // The first exception is kept for who waits.
  template <class Work>
  void attempt(const Work& work) {
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failed_) failed_ = std::current_exception();
    }
  }
  // Tasks may run more of them meanwhile.
  void join() {
    for (;;) {
      std::vector<std::thread> begun;
      {
        const std::lock_guard lock(mutex_);
        begun.swap(threads_);
      }
      if (begun.empty()) return;
      for (std::thread& thread : begun) thread.join();
    }
  }

  std::mutex mutex_;
  std::vector<std::thread> threads_;
  std::exception_ptr failed_;
};

template <class Index>
class blocked_range {
 public:
  blocked_range(Index begin, Index end, Index grain = 1) : begin_(begin), end_(end), grain_(grain) {}
  Index begin() const { return begin_; }
  Index end() const { return end_; }

  // Parts of this one: no more than a few, each of about `grain` indices or more.
  std::size_t parts() const {
    constexpr std::size_t most = 64;
    const auto size = static_cast<std::size_t>(begin_ < end_ ? end_ - begin_ : 0);
    return std::min(most, (size + static_cast<std::size_t>(grain_) - 1) / static_cast<std::size_t>(grain_));
  }
  blocked_range part(std::size_t i) const {
    const auto at = [&](std::size_t k) {
      return static_cast<Index>(begin_ + (end_ - begin_) / parts() * k + std::min<std::size_t>(k, (end_ - begin_) % parts()));
    };
    return {at(i), at(i + 1), grain_};
  }

 private:
  Index begin_, end_, grain_;
};

template <class Range, class Body>
void parallel_for(const Range& range, const Body& body) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < range.parts();) body(range.part(i));
  };
  task_group group;
  for (std::size_t i = 1; i < std::min<std::size_t>(range.parts(), 4); ++i) group.run(work);
  group.run_and_wait(work);
}

template <class Range, class Value, class Body, class Join>
Value parallel_reduce(const Range& range, const Value& identity, const Body& body, const Join& join) {
  std::vector<Value> values(range.parts(), identity);
  parallel_for(blocked_range<std::size_t>(0, values.size()), [&](const auto& some) {
    for (std::size_t i = some.begin(); i != some.end(); ++i) values[i] = body(range.part(i), identity);
  });
  Value sum = identity;
  for (const Value& value : values) sum = join(sum, value);
  return sum;
}

template <class First, class Second>
void parallel_invoke(const First& first, const Second& second) {
  task_group group;
  group.run(second);
  group.run_and_wait(first);
}

namespace this_task_arena {

template <class Body>
void isolate(const Body& body) {
  body();
}

}  // namespace this_task_arena

class task_arena {
 public:
  explicit task_arena(int) {}
  template <class Body>
  void execute(const Body& body) {
    body();
  }
};

class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter, std::size_t) {}
};

namespace info {

inline int default_concurrency() { return 4; }

}  // namespace info

}  // namespace tbb
