// Random numbers that depend on what they are used for, never on the thread that draws them.
#pragma once

#include <bit>
#include <cstdint>

namespace etendue {

// SplitMix64's finaliser: a bijection on 64 bits with full avalanche ([Steele2014]).
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

template <class... Keys>
constexpr std::uint64_t hash_keys(Keys... keys) {
  std::uint64_t h = 0x2545f4914f6cdd1dull;
  ((h = mix_bits(h ^ static_cast<std::uint64_t>(keys))), ...);
  return h;
}

// 32 random bits to [0, 1): the largest result is 1 - 2^-24.
constexpr float to_unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

// PCG-XSH-RR 64/32 ([ONeill2014]).
class Pcg32 {
 public:
  Pcg32(std::uint64_t seed, std::uint64_t sequence) : increment_((sequence << 1) | 1) {
    next();
    state_ += seed;
    next();
  }
  std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ull + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    return std::rotr(shifted, static_cast<int>(old >> 59));
  }
  float next_float() { return to_unit_float(next()); }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

}  // namespace etendue
