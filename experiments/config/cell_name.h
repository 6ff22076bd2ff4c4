// The name of a cell of an experiment.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace etendue {

// The labels are those that charts print ("binned-sah", "photon-map photons=200000").
struct CellName {
  std::string scene, accel, integrator;
  std::uint64_t seed = 0;

  std::string key() const;  // "scene | accel | integrator | seed=N": unique within an experiment
  auto operator<=>(const CellName&) const = default;
};

}  // namespace etendue
