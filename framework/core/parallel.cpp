#include "framework/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <utility>

namespace etendue {

void parallel_parts(std::size_t count, std::size_t grain, const void* body,
                    void (*run)(const void* body, std::size_t begin, std::size_t end)) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [=](const tbb::blocked_range<std::size_t>& part) { run(body, part.begin(), part.end()); });
}

void with_threads(int threads, const std::function<void()>& body) {
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute(body);
}

struct TaskGroup::State {
  tbb::task_group group;
};

TaskGroup::TaskGroup() : state_(std::make_unique<State>()) {}
TaskGroup::~TaskGroup() = default;

void TaskGroup::run(std::function<void()> task) { state_->group.run(std::move(task)); }
void TaskGroup::wait() { state_->group.wait(); }
void TaskGroup::run_and_wait(const std::function<void()>& task) { state_->group.run_and_wait(task); }

int hardware_threads() { return tbb::info::default_concurrency(); }

}  // namespace etendue
