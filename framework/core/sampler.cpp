#include "framework/core/sampler.h"

namespace etendue {

namespace {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(x);
}

// Laine-Karras style permutation of the reversed bits: every bit is flipped depending only on the bits below it. Constants of
// [Vegdahl2021].
constexpr std::uint32_t permute_upwards(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

}  // namespace

std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) {
  return reverse_bits(permute_upwards(reverse_bits(x), seed));
}

std::uint32_t sobol_second_dimension(std::uint32_t index) {
  // Direction numbers of the polynomial x + 1: each is the previous one xor its half.
  std::uint32_t result = 0;
  for (std::uint32_t direction = 0x80000000u; index != 0; index >>= 1, direction ^= direction >> 1)
    if (index & 1) result ^= direction;
  return result;
}

vec2 Sampler::sobol_2d() {
  // [Burley2020]: shuffle the index by Owen-scrambling it bit-reversed (which permutes within aligned blocks of 2^k), then
  // scramble each dimension.
  const std::uint64_t h = hash_keys(key_, dimension_++);
  const std::uint64_t g = mix_bits(h);
  const std::uint32_t index = owen_scramble(index_, static_cast<std::uint32_t>(h));
  const std::uint32_t x = owen_scramble(reverse_bits(index), static_cast<std::uint32_t>(g));
  const std::uint32_t y = owen_scramble(sobol_second_dimension(index), static_cast<std::uint32_t>(g >> 32));
  return {to_unit_float(x), to_unit_float(y)};
}

}  // namespace etendue
