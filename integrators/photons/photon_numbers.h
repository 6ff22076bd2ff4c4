// The random numbers of photons' paths.
//
// A path is a function of the numbers it draws, the same ones in the same places whatever it meets: five for the light, its
// point and the direction, then two for lobe and survival and two for the direction at each event. So the numbers can be chosen
// independently, by a guide, or by a Markov chain that changes those of an earlier path.
#pragma once

#include "framework/core/sampler.h"
#include "integrators/photons/photons.h"

#include <array>

namespace etendue {

// The numbers a photon is emitted by.
inline constexpr int emission_dimensions = 5;
using EmissionNumbers = std::array<float, emission_dimensions>;

// The source of numbers for the paths of one key: the pass's sampler for emission, independent numbers for scattering. After
// one diffuse event a low-discrepancy sequence no longer lowers the variance within a kernel, and its numbers cost more.
class PathNumbers {
 public:
  PathNumbers(std::uint64_t seed, const PhotonPass& pass, std::uint64_t key)
      : sampler_(pass.sampler), seed_(seed), key_(key), scattering_(hash_keys(seed, key)), points_(points<float>()) {}

  SamplerKind sampler() const { return sampler_; }
  EmissionNumbers emission(std::uint32_t index) const {
    if (sampler_ == SamplerKind::sobol) return points_(index);
    Sampler sampler(sampler_, seed_, Stream::light_path, key_, index);
    const float light = sampler.get_1d();
    const vec2 position = sampler.get_2d(), direction = sampler.get_2d();
    return {light, position.x, position.y, direction.x, direction.y};
  }

  // Those of `emission` by Sobol's sequence, over lanes.
  template <class F>
  struct Points {
    SobolPairOf<F> light, position, direction;

    std::array<F, emission_dimensions> operator()(Bits<F> index) const {
      const Vec2<F> p = position.point(index), d = direction.point(index);
      return {light.first(index), p.x, p.y, d.x, d.y};
    }
  };
  template <class F>
  Points<F> points() const {
    const std::uint64_t sequence = sequence_key(seed_, Stream::light_path, key_);
    const auto pair = [sequence](int n) { return SobolPairOf<F>(LongBits<F>(hash_keys(sequence, n))); };
    return {pair(0), pair(1), pair(2)};
  }
  template <class F>
  PcgOf<F> scattering(Bits<F> index) const {
    PcgOf<F> numbers{LongBits<F>(std::uint64_t{0}), LongBits<F>(key_ << 1 | 1)};  // as Pcg32 begins
    numbers.next();
    numbers.state += mix_long_bits(LongBits<F>(scattering_) ^ long_bits(index));
    numbers.next();
    return numbers;
  }

 private:
  SamplerKind sampler_;
  std::uint64_t seed_, key_, scattering_;
  Points<float> points_;
};

// Those of path `index`.
class SampledNumbers {
 public:
  SampledNumbers(const PathNumbers& all, std::uint32_t index)
      : all_(&all), index_(index), scattering_(all.scattering<float>(index)) {}
  EmissionNumbers emission() const { return all_->emission(index_); }
  vec2 pair() {
    const float x = scattering_.next_float();
    return {x, scattering_.next_float()};
  }

 private:
  const PathNumbers* all_;
  std::uint32_t index_;
  PcgOf<float> scattering_;
};

}  // namespace etendue
