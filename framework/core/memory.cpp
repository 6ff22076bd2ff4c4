#include "framework/core/memory.h"

#include "framework/core/units.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>
#if defined(__linux__)
#include <malloc.h>
#endif

#include <algorithm>
#include <fstream>
#include <optional>

namespace etendue {

namespace {

constexpr std::uint64_t unlimited = std::uint64_t{1} << 63;

// The number after `key` in a file of lines "key: number unit" or "key number".
std::optional<std::uint64_t> entry(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string name; in >> name; in.ignore(256, '\n'))
    if (std::uint64_t value = 0; name == key && in >> value) return value;
  return std::nullopt;
}

std::optional<std::uint64_t> number_in(const std::string& file) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  return in >> value ? std::optional(value) : std::nullopt;
}

std::uint64_t left_of(std::uint64_t limit, std::uint64_t taken) { return limit > taken ? limit - taken : 0; }

std::uint64_t limit_of_process = 0;

std::uint64_t left_in_system() {
  const auto available = entry("/proc/meminfo", "MemAvailable:"), swap = entry("/proc/meminfo", "SwapFree:");
  return available ? 1024 * (*available + swap.value_or(0)) : unlimited;
}

std::uint64_t left_in_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  const auto pages = number_in("/proc/self/statm");
  return left_of(limit.rlim_cur, pages.value_or(0) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)));
}

// Pages of files are given up when memory is short.
std::uint64_t left_in_control_group() {
  std::uint64_t left = unlimited;
  std::string path;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);)
    if (line.starts_with("0::/")) path = line.substr(3);
  // The groups above limit it too.
  for (;; path.erase(path.rfind('/'))) {
    const std::string group = "/sys/fs/cgroup" + path;
    if (const auto most = number_in(group + "/memory.max"))
      left = std::min(left, left_of(*most, left_of(number_in(group + "/memory.current").value_or(0),
                                                   entry(group + "/memory.stat", "file").value_or(0))));
    if (path.empty()) return left;
  }
}

}  // namespace

void keep_freed_memory() {
#if defined(__GLIBC__)
  // Where the address space is short, nothing is kept beyond what is used, and no thread takes 64 MiB of it for itself.
  if (rlimit limit{}; getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur < rlim_t{4} << 30) {
    mallopt(M_ARENA_MAX, 1);
    return;
  }
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TOP_PAD, 64 << 20);
#endif
}

void release_freed_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

void set_memory_limit(std::uint64_t bytes) { limit_of_process = bytes; }

std::uint64_t memory_limit() { return limit_of_process; }

std::uint64_t resident_memory_bytes() {
  release_freed_memory();
  std::ifstream in("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  return in >> all >> resident ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::uint64_t available_memory_bytes() {
  release_freed_memory();
  const std::uint64_t own = limit_of_process == 0 ? unlimited : left_of(limit_of_process, resident_memory_bytes());
  return std::min({left_in_system(), left_in_address_space(), left_in_control_group(), own});
}

void require_memory(double bytes, const Location& where, const std::string& what, const std::string& expectation) {
  const auto available = static_cast<double>(available_memory_bytes());
  if (bytes <= available) return;
  throw Error(where, fmt::format("{} needs about {}, and {} are free; expected {}", what, format_bytes(bytes),
                                 format_bytes(available), expectation));
}

}  // namespace etendue
