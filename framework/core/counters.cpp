#include "framework/core/counters.h"

#include <sys/resource.h>
#include <mutex>
#include <vector>

namespace etendue {

namespace {

struct Registry {
  std::mutex mutex;
  std::vector<detail::ThreadCounters*> living;
  CounterValues ended{};
};

// Never destroyed: threads may end after main's statics.
Registry& registry() {
  static auto* instance = new Registry;
  return *instance;
}

void add(CounterValues& sum, const CounterValues& values) {
  for (std::size_t i = 0; i < counter_count; ++i) sum[i] += values[i];
}

}  // namespace

std::string_view counter_name(Counter counter) {
  static constexpr std::array<std::string_view, counter_count> names{
      "rays", "shadow_rays", "photons_emitted", "photons_stored", "photons_gathered", "records", "lookups"};
  return names[static_cast<std::size_t>(counter)];
}

namespace detail {

ThreadCounters::ThreadCounters() {
  const std::lock_guard lock(registry().mutex);
  registry().living.push_back(this);
}

ThreadCounters::~ThreadCounters() {
  const std::lock_guard lock(registry().mutex);
  std::erase(registry().living, this);
  add(registry().ended, values);
}

ThreadCounters& thread_counters() {
  thread_local ThreadCounters counters;
  return counters;
}

}  // namespace detail

CounterValues read_counters() {
  const std::lock_guard lock(registry().mutex);
  CounterValues sum = registry().ended;
  for (const auto* counters : registry().living) add(sum, counters->values);
  return sum;
}

void reset_counters() {
  const std::lock_guard lock(registry().mutex);
  registry().ended = {};
  for (auto* counters : registry().living) counters->values = {};
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace etendue
