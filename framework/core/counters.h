// Counters of work, which unlike times have no noise. Each thread counts on its own; reading sums over the threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace etendue {

enum class Counter : std::uint8_t {
  rays,         // closest-hit queries by integrators
  shadow_rays,  // occlusion queries by integrators
  photons_emitted,
  photons_stored,
  photons_gathered,
  records,  // cache records made
  lookups,  // cache lookups
  count_
};

inline constexpr std::size_t counter_count = static_cast<std::size_t>(Counter::count_);
using CounterValues = std::array<std::uint64_t, counter_count>;

std::string_view counter_name(Counter counter);

namespace detail {
struct ThreadCounters {
  CounterValues values{};
  ThreadCounters();
  ~ThreadCounters();
};
ThreadCounters& thread_counters();
}  // namespace detail

inline void count(Counter counter, std::uint64_t by = 1) {
  detail::thread_counters().values[static_cast<std::size_t>(counter)] += by;
}

// Sums over all threads, living and ended. Call between parallel loops.
CounterValues read_counters();
void reset_counters();

// Peak resident memory of the process, in bytes.
std::uint64_t peak_memory_bytes();

}  // namespace etendue
