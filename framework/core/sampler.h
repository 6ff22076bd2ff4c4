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
enum class Stream : std::uint32_t { camera, light_path, cache_record, prefill, gather, test, probe };

// Nested uniform (Owen) scrambling of a 32-bit fixed-point number.
std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed);
// Second dimension of the Sobol sequence (the first is the bit reversal).
std::uint32_t sobol_second_dimension(std::uint32_t index);

class Sampler {
 public:
  Sampler(SamplerKind kind, std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t iteration)
      : kind_(kind),
        index_(iteration),
        key_(hash_keys(seed, static_cast<std::uint32_t>(stream), pixel)),
        pcg_(hash_keys(key_, iteration), key_) {}

  float get_1d() { return kind_ == SamplerKind::independent ? pcg_.next_float() : sobol_1d(); }
  vec2 get_2d() {
    if (kind_ == SamplerKind::sobol) return sobol_2d();
    const float x = pcg_.next_float();
    return {x, pcg_.next_float()};
  }

 private:
  float sobol_1d();  // sobol_2d().x
  vec2 sobol_2d();

  SamplerKind kind_;
  std::uint32_t index_;
  std::uint32_t dimension_ = 0;
  std::uint64_t key_;
  Pcg32 pcg_;
};

}  // namespace etendue
