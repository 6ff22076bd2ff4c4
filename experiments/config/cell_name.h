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
  // Whether it stands for this scene, or for a set that is named for the scene and what varies in it.
  bool is_of(const std::string& other) const { return scene == other || scene.starts_with(other + " "); }
  auto operator<=>(const CellName&) const = default;
};

}  // namespace etendue
