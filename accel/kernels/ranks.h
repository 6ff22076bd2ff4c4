// The rank of each of up to sixteen different numbers in ascending order, found by counting those below it: no branch depends
// on the numbers.
#pragma once

#include "accel/kernels/simd_bounds.h"

#include <cstddef>
#include <cstring>

namespace etendue {

class Ranks {
 public:
  static constexpr std::size_t most = 16;

  Ranks(const std::uint32_t* numbers, std::size_t count) {
    alignas(16) std::uint32_t padded[most];
    std::memset(padded, 0xff, sizeof padded);
    for (std::size_t i = 0; i < count; ++i) padded[i] = numbers[i];
    FourUnsigned values[most / 4], ranks[most / 4]{};
    std::memcpy(values, padded, sizeof values);
    const std::size_t used = (count + 3) / 4;
    for (std::size_t n = 0; n < count; ++n)
      for (std::size_t i = 0; i < used; ++i) ranks[i] -= (FourUnsigned)(values[i] > numbers[n]);
    std::memcpy(ranks_, ranks, sizeof ranks);
  }
  std::uint32_t operator[](std::size_t i) const { return ranks_[i]; }

 private:
  std::uint32_t ranks_[most];
};

}  // namespace etendue
