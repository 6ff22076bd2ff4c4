// A model of a processor's cache that counts misses: sets of lines of 64 bytes, replacing the least recently used of a set.
// Virtual machines hide the processor's own counters; this model sees only the addresses that a traversal touches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace etendue {

class CacheModel {
 public:
  CacheModel(std::size_t bytes, std::size_t ways)
      : ways_(ways), sets_(bytes / line_bytes / ways), lines_(sets_ * ways, ~0ull) {}

  void touch(const void* address, std::size_t bytes) {
    const auto begin = reinterpret_cast<std::uintptr_t>(address);
    for (std::uintptr_t line = begin / line_bytes; line <= (begin + bytes - 1) / line_bytes; ++line) touch_line(line);
  }
  std::uint64_t misses() const { return misses_; }
  std::uint64_t accesses() const { return accesses_; }
  void reset_counts() { misses_ = accesses_ = 0; }

 private:
  static constexpr std::size_t line_bytes = 64;

  // The first line of a set is the most recently used.
  void touch_line(std::uint64_t line) {
    ++accesses_;
    std::uint64_t* set = &lines_[line % sets_ * ways_];
    std::size_t i = 0;
    while (i + 1 < ways_ && set[i] != line) ++i;
    misses_ += set[i] != line;
    for (; i > 0; --i) set[i] = set[i - 1];
    set[0] = line;
  }

  std::size_t ways_, sets_;
  std::vector<std::uint64_t> lines_;
  std::uint64_t misses_ = 0, accesses_ = 0;
};

}  // namespace etendue
