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

float Sampler::sobol_1d() {
  const std::uint64_t h = hash_keys(key_, dimension_++);
  const std::uint32_t index = owen_scramble(index_, static_cast<std::uint32_t>(h));
  return to_unit_float(reverse_bits(permute_upwards(index, static_cast<std::uint32_t>(mix_bits(h)))));
}

vec2 Sampler::sobol_2d() {
  // [Burley2020]: shuffle the index by Owen-scrambling it bit-reversed (which permutes within aligned blocks of 2^k), then
  // scramble each dimension: owen_scramble(reverse_bits(index)) and owen_scramble(sobol_second_dimension(index)), less the
  // reversals that undo each other.
  const std::uint64_t h = hash_keys(key_, dimension_++);
  const std::uint64_t g = mix_bits(h);
  const std::uint32_t index = owen_scramble(index_, static_cast<std::uint32_t>(h));
  const std::uint32_t x = reverse_bits(permute_upwards(index, static_cast<std::uint32_t>(g)));
  const std::uint32_t y = reverse_bits(permute_upwards(pascal(index), static_cast<std::uint32_t>(g >> 32)));
  return {to_unit_float(x), to_unit_float(y)};
}

}  // namespace etendue
