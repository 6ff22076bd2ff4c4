// How a wave is sorted for lanes, and which instruction set runs it. A kernel is compiled in integrators/lanes/, once for each
// instruction set, and works on runs of one material.
#pragma once

#include "framework/core/isa.h"
#include "framework/materials/material.h"

#include <span>
#include <vector>

namespace etendue {

// The part of a wave that met a surface, in runs of one kind: one material, on triangles or other surfaces, ended or not.
class Runs {
 public:
  void reset(std::size_t kinds) { starts_.assign(kinds + 1, 0); }
  void add(std::size_t kind, std::uint32_t i) {
    met_.push_back({static_cast<std::uint32_t>(kind), i});
    ++starts_[kind + 1];
  }
  // body(kind, which) for each kind that has some, in order.
  template <class Body>
  void each(const Body& body) {
    for (std::size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
    sorted_.resize(met_.size());
    next_ = starts_;
    for (const Met& m : met_) sorted_[next_[m.kind]++] = m.i;
    for (std::size_t k = 0; k + 1 < starts_.size(); ++k)
      if (starts_[k] < starts_[k + 1])
        body(k, std::span<const std::uint32_t>(sorted_).subspan(starts_[k], starts_[k + 1] - starts_[k]));
    met_.clear();
  }

 private:
  struct Met {
    std::uint32_t kind, i;
  };
  std::vector<Met> met_;
  std::vector<std::uint32_t> starts_, next_, sorted_;
};

// A material without its variant, for a kernel of its kind.
inline const void* contents_of(const Material& material) {
  return std::visit([](const auto& m) -> const void* { return &m; }, material);
}

template <class Kernels>
const Kernels& kernels_of_isa(const Kernels& (*one)(), const Kernels& (*sse)(), const Kernels& (*avx2)(),
                              const Kernels& (*avx512)()) {
  switch (chosen_isa()) {
    case Isa::avx512:
      return avx512();
    case Isa::avx2:
      return avx2();
    case Isa::sse:
      return sse();
    case Isa::scalar:
      break;
  }
  return one();
}

}  // namespace etendue
