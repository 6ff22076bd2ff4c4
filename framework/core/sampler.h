// The sampler an integrator draws from, keyed by (seed, stream, pixel, iteration) and nothing else; over lanes (lanes.h), too.
//
// `sobol` pads two-dimensional Owen-scrambled Sobol points: every pair of dimensions is the first two Sobol dimensions,
// scrambled and shuffled by hashes ([Burley2020], with the hash of [Vegdahl2021]); the iteration is the index into the
// sequence, so iterations of one pixel stratify each other. `independent` is PCG.
#pragma once

#include "framework/core/rng.h"

#include <array>

namespace etendue {

enum class SamplerKind : std::uint8_t { sobol, independent };
constexpr auto names_of(SamplerKind) { return std::array{"sobol", "independent"}; }

// Says what the numbers are for. Two uses with different streams are independent.
enum class Stream : std::uint32_t { camera, light_path, cache_record, initial_pass, gather, test, probe };

template <class B>
B reverse_bits(B x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  return swap_bytes(x);
}

// Laine-Karras style permutation of the reversed bits: every bit is flipped depending only on the bits below it. Constants of
// [Vegdahl2021].
template <class B>
B permute_upwards(B x, B seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Nested uniform (Owen) scrambling of a 32-bit fixed-point number.
template <class B>
B owen_scramble(B x, B seed) {
  return reverse_bits(permute_upwards(reverse_bits(x), seed));
}

// Pascal's triangle modulo 2 times the bits of x: bit i of the result is the parity of the bits j of x with i a subset of j
// (Lucas), a butterfly of five steps. It is the generator matrix of the second Sobol dimension, bits reversed.
template <class B>
B pascal(B x) {
  x ^= (x >> 1) & 0x55555555u;
  x ^= (x >> 2) & 0x33333333u;
  x ^= (x >> 4) & 0x0f0f0f0fu;
  x ^= (x >> 8) & 0x00ff00ffu;
  return x ^ (x >> 16);
}

// Second dimension of the Sobol sequence (the first is the bit reversal).
inline std::uint32_t sobol_second_dimension(std::uint32_t index) { return reverse_bits(pascal(index)); }

// One pair of dimensions of `sobol` with its scrambling. Code that needs many points of one sequence keeps the pairs, where a
// Sampler per point would compute the same hashes again and again.
//
// [Burley2020]: shuffle the index by Owen-scrambling it bit-reversed (which permutes within aligned blocks of 2^k), then
// scramble each dimension: owen_scramble(reverse_bits(index)) and owen_scramble(sobol_second_dimension(index)), less the
// reversals that undo each other.
template <class F>
class SobolPairOf {
 public:
  SobolPairOf() = default;
  explicit SobolPairOf(LongBits<F> hash) : shuffle_(low_bits(hash)) {
    const LongBits<F> mixed = mix_long_bits(hash);
    first_ = low_bits(mixed);
    second_ = high_bits(mixed);
  }

  Vec2<F> point(Bits<F> index) const {
    const Bits<F> i = owen_scramble(index, shuffle_);
    return {to_unit_float(reverse_bits(permute_upwards(i, first_))),
            to_unit_float(reverse_bits(permute_upwards(pascal(i), second_)))};
  }
  F first(Bits<F> index) const {  // point(index).x
    return to_unit_float(reverse_bits(permute_upwards(owen_scramble(index, shuffle_), first_)));
  }

 private:
  Bits<F> shuffle_, first_, second_;
};

// The numbers of one sequence, or of one in each lane; all are of one kind.
template <class F>
struct SamplerOf {
  SamplerKind kind;
  Bits<F> index, dimension;
  LongBits<F> key;  // of the sequence; for `sobol` hashed, so that a dimension's hash is one step away
  PcgOf<F> pcg;     // for `independent`

  F get_1d() { return kind == SamplerKind::independent ? pcg.next_float() : next_pair().first(index); }
  Vec2<F> get_2d() {
    if (kind == SamplerKind::sobol) return next_pair().point(index);
    const F x = pcg.next_float();
    return {x, pcg.next_float()};
  }

 private:
  SobolPairOf<F> next_pair() {
    const LongBits<F> hash = mix_long_bits(key ^ long_bits(dimension));
    dimension += 1u;
    return SobolPairOf<F>(hash);
  }
};

constexpr std::uint64_t sequence_key(std::uint64_t seed, Stream stream, std::uint64_t pixel) {
  return hash_keys(seed, static_cast<std::uint32_t>(stream), pixel);
}

class Sampler : public SamplerOf<float> {
 public:
  Sampler(SamplerKind kind, std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t iteration)
      : Sampler(kind, sequence_key(seed, stream, pixel), iteration) {}

 private:
  Sampler(SamplerKind kind, std::uint64_t sequence, std::uint32_t iteration)
      : SamplerOf{kind, iteration, 0, kind == SamplerKind::independent ? sequence : hash_keys(sequence),
                  kind == SamplerKind::independent ? Pcg32(hash_keys(sequence, iteration), sequence) : PcgOf<float>{}} {}
};

// The n-th pair that a Sampler with these keys draws.
struct SobolPair : SobolPairOf<float> {
  using SobolPairOf::SobolPairOf;
  SobolPair(std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t n)
      : SobolPairOf(hash_keys(sequence_key(seed, stream, pixel), n)) {}
};

}  // namespace etendue
