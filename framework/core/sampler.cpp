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

// Pascal's triangle modulo 2 times the bits of x: bit i of the result is the parity of the bits j of x with i a subset of j
// (Lucas), a butterfly of five steps. It is the generator matrix of the second Sobol dimension, bits reversed.
constexpr std::uint32_t pascal(std::uint32_t x) {
  x ^= (x >> 1) & 0x55555555u;
  x ^= (x >> 2) & 0x33333333u;
  x ^= (x >> 4) & 0x0f0f0f0fu;
  x ^= (x >> 8) & 0x00ff00ffu;
  return x ^ x >> 16;
}

}  // namespace

std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) {
  return reverse_bits(permute_upwards(reverse_bits(x), seed));
}

std::uint32_t sobol_second_dimension(std::uint32_t index) { return reverse_bits(pascal(index)); }

// [Burley2020]: shuffle the index by Owen-scrambling it bit-reversed (which permutes within aligned blocks of 2^k), then
// scramble each dimension: owen_scramble(reverse_bits(index)) and owen_scramble(sobol_second_dimension(index)), less the
// reversals that undo each other.
vec2 SobolPair::point(std::uint32_t index) const {
  const std::uint32_t i = owen_scramble(index, shuffle_);
  const std::uint32_t x = reverse_bits(permute_upwards(i, first_));
  const std::uint32_t y = reverse_bits(permute_upwards(pascal(i), second_));
  return {to_unit_float(x), to_unit_float(y)};
}

float SobolPair::first(std::uint32_t index) const {
  return to_unit_float(reverse_bits(permute_upwards(owen_scramble(index, shuffle_), first_)));
}

}  // namespace etendue
