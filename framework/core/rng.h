// Random numbers that depend on what they are used for, never on the thread that draws them; over lanes (lanes.h), too.
#pragma once

#include "framework/core/lanes.h"

namespace etendue {

// SplitMix64's finaliser: a bijection on 64 bits with full avalanche ([Steele2014]).
template <class Long>
constexpr Long mix_long_bits(Long x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
constexpr std::uint64_t mix_bits(std::uint64_t x) { return mix_long_bits(x); }

template <class... Keys>
constexpr std::uint64_t hash_keys(Keys... keys) {
  std::uint64_t h = 0x2545f4914f6cdd1dull;
  ((h = mix_bits(h ^ static_cast<std::uint64_t>(keys))), ...);
  return h;
}

// 32 random bits to [0, 1): the largest result is 1 - 2^-24.
template <class B>
auto to_unit_float(B bits) {
  return to_float(bits >> 8) * 0x1p-24f;
}

// PCG-XSH-RR 64/32 ([ONeill2014]).
template <class F>
struct PcgOf {
  LongBits<F> state, increment;

  Bits<F> next() {
    const LongBits<F> old = state;
    state = old * 6364136223846793005ull + increment;
    return rotate_right(low_bits(((old >> 18) ^ old) >> 27), high_bits(old) >> 27);
  }
  F next_float() { return to_unit_float(next()); }
};
struct Pcg32 : PcgOf<float> {
  Pcg32(std::uint64_t seed, std::uint64_t sequence) : PcgOf{0, (sequence << 1) | 1} {
    next();
    state += seed;
    next();
  }
};

}  // namespace etendue
