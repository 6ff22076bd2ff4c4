// The sampler an integrator draws from, keyed by (seed, stream, pixel, iteration) and nothing else.
//
// `sobol` pads two-dimensional Owen-scrambled Sobol points: every pair of dimensions is the first two Sobol dimensions,
// scrambled and shuffled by hashes ([Burley2020], with the hash of [Vegdahl2021]); the iteration is the index into the
// sequence, so iterations of one pixel stratify each other. `independent` is PCG.
#pragma once

#include "framework/core/rng.h"
#include "framework/core/vec.h"

namespace etendue {

enum class SamplerKind : std::uint8_t { independent, sobol };

// What the numbers are for. Two uses with different streams are independent.
enum class Stream : std::uint32_t { camera, light_path, cache_record, initial_pass, gather, test, probe };

// Nested uniform (Owen) scrambling of a 32-bit fixed-point number.
std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed);
// Second dimension of the Sobol sequence (the first is the bit reversal).
std::uint32_t sobol_second_dimension(std::uint32_t index);

// One pair of dimensions of `sobol` with its scrambling. Code that needs many points of one sequence keeps the pairs, where a
// Sampler per point would compute the same hashes again and again.
class SobolPair {
 public:
  SobolPair() = default;
  explicit SobolPair(std::uint64_t hash)
      : shuffle_(static_cast<std::uint32_t>(hash)),
        first_(static_cast<std::uint32_t>(mix_bits(hash))),
        second_(static_cast<std::uint32_t>(mix_bits(hash) >> 32)) {}
  // The n-th pair that a Sampler with these keys draws.
  SobolPair(std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t n);

  vec2 point(std::uint32_t index) const;
  float first(std::uint32_t index) const;  // point(index).x

 private:
  std::uint32_t shuffle_, first_, second_;
};

class Sampler {
 public:
  Sampler(SamplerKind kind, std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t iteration)
      : kind_(kind),
        index_(iteration),
        key_(kind == SamplerKind::independent ? sequence_key(seed, stream, pixel)
                                              : hash_keys(sequence_key(seed, stream, pixel))),
        pcg_(kind == SamplerKind::independent ? Pcg32(hash_keys(key_, iteration), key_) : Pcg32(0, 0)) {}

  float get_1d() { return kind_ == SamplerKind::independent ? pcg_.next_float() : next_pair().first(index_); }
  vec2 get_2d() {
    if (kind_ == SamplerKind::sobol) return next_pair().point(index_);
    const float x = pcg_.next_float();
    return {x, pcg_.next_float()};
  }

 private:
  friend class SobolPair;

  static constexpr std::uint64_t sequence_key(std::uint64_t seed, Stream stream, std::uint64_t pixel) {
    return hash_keys(seed, static_cast<std::uint32_t>(stream), pixel);
  }
  SobolPair next_pair() { return SobolPair(mix_bits(key_ ^ dimension_++)); }

  SamplerKind kind_;
  std::uint32_t index_;
  std::uint32_t dimension_ = 0;
  std::uint64_t key_;  // of the sequence; for `sobol` hashed, so that a dimension's hash is one step away
  Pcg32 pcg_;          // for `independent`
};

inline SobolPair::SobolPair(std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t n)
    : SobolPair(hash_keys(Sampler::sequence_key(seed, stream, pixel), n)) {}

}  // namespace etendue
