#include "integrators/photons/emission/photon_chains.h"

#include "framework/core/elementary.h"
#include "integrators/photons/photon_path.h"

namespace etendue {

namespace {

constexpr std::size_t sequences = 16;

// Replays a uniform path, and notes its numbers in the order it draws them: as many as it needs.
struct ReplayedNumbers {
  SampledNumbers numbers;
  std::vector<float>& noted;

  EmissionNumbers emission() {
    const EmissionNumbers u = numbers.emission();
    noted.assign(u.begin(), u.end());
    return u;
  }
  vec2 pair() {
    const vec2 u = numbers.pair();
    noted.insert(noted.end(), {u.x, u.y});
    return u;
  }
};

// Mutates the numbers of `from` as they are drawn, and notes them in `to`. Numbers beyond those of `from`, on which its
// visibility did not depend, are uniform there, and so are here.
class MutatedNumbers {
 public:
  MutatedNumbers(const std::vector<float>& from, std::vector<float>& to, float size, Pcg32& random)
      : from_(from), to_(to), exponent_(1 / size + 1), random_(random) {
    to_.clear();
  }

  EmissionNumbers emission() {
    EmissionNumbers u;
    for (float& x : u) x = next();
    return u;
  }
  vec2 pair() {
    const float x = next();
    return {x, next()};
  }

 private:
  float next() {
    const float r = random_.next_float();
    float u = r;
    if (const std::size_t i = to_.size(); i < from_.size()) {
      const float moved = from_[i] + (r < 0.5f ? math::pow(2 * r, exponent_) : -math::pow(2 * r - 1, exponent_));
      u = std::min(moved - std::floor(moved), 0x1.fffffep-1f);
    }
    to_.push_back(u);
    return u;
  }

  const std::vector<float>& from_;
  std::vector<float>& to_;
  float exponent_;
  Pcg32& random_;
};

// Stretches one after the other, with what they have learned of the size of mutations.
class ChainSequence {
 public:
  ChainSequence(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass,
                const PathNumbers& uniform, std::uint64_t id, Photons& out)
      : uniform_(uniform),
        tracer_(context, rough_materials, pass),
        random_(hash_keys(context.seed, static_cast<std::uint32_t>(Stream::light_path), pass.key, 2), id),
        out_(out) {}

  // From uniform path `seed` over `length` states that each count `share`.
  void run(std::uint32_t seed, std::uint32_t length, float share) {
    ReplayedNumbers replay{{uniform_, seed}, numbers_};
    held_.clear();
    tracer_.trace(replay, share, held_);
    std::uint32_t steps = 1;
    for (std::uint32_t i = 1; i < length; ++i) {
      MutatedNumbers mutated(numbers_, proposed_numbers_, size_, random_);
      proposed_.clear();
      const bool taken = tracer_.trace(mutated, share, proposed_);
      ++tried_;
      if (taken) {
        ++taken_;
        store(steps);
        steps = 0;
        std::swap(held_, proposed_);
        std::swap(numbers_, proposed_numbers_);
      }
      ++steps;
      size_ = std::clamp(size_ + (taken_ / tried_ - 0.234f) / tried_, 1e-3f, 1e3f);
    }
    store(steps);
  }

 private:
  void store(std::uint32_t steps) {
    for (Rgb& power : held_.power) power *= static_cast<float>(steps);
    out_.append(held_);
  }

  const PathNumbers& uniform_;
  PhotonTracer tracer_;
  Pcg32 random_;
  Photons& out_;
  Photons held_, proposed_;
  std::vector<float> numbers_, proposed_numbers_;
  float size_ = 1, taken_ = 0, tried_ = 0;
};

}  // namespace

Photons trace_by_visibility(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass) {
  const std::uint32_t uniform = (pass.count + 1) / 2;
  std::vector<std::uint8_t> visible(uniform);
  const PathNumbers of_pass(context.seed, pass, pass.key);
  trace_in_chunks(uniform, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
    PhotonTracer tracer(context, rough_materials, pass);
    for (std::uint32_t i = first; i < last; ++i, out.clear()) {
      SampledNumbers numbers(of_pass, i);
      visible[i] = tracer.trace(numbers, 1, out);
    }
  });
  std::vector<std::uint32_t> seeds;
  for (std::uint32_t i = 0; i < uniform; ++i)
    if (visible[i]) seeds.push_back(i);
  if (seeds.empty()) return {};

  // Stretches differ in length by one at most; each has a share of its own, so that none counts more than another.
  const std::size_t states = std::max<std::size_t>(pass.count - uniform, seeds.size());
  const std::size_t shortest = states / seeds.size(), longer = states % seeds.size();
  std::vector<Photons> parts(sequences);
  parallel_for(sequences, 1, [&](std::size_t s) {
    ChainSequence sequence(context, rough_materials, pass, of_pass, s, parts[s]);
    for (std::size_t j = seeds.size() * s / sequences; j < seeds.size() * (s + 1) / sequences; ++j) {
      const std::size_t length = shortest + (j < longer);
      sequence.run(seeds[j], static_cast<std::uint32_t>(length),
                   1 / (static_cast<float>(uniform) * static_cast<float>(length)));
    }
  });
  return joined(std::move(parts));
}

}  // namespace etendue
