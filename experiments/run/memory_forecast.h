// The memory that a cell takes at its peak, predicted before anything of it is built, and kept within `--memory`.
//
// The whole program has one limit (framework/core/memory.h). The parts of a forecast are
//
//   program and scene   what is resident once the scene has been read; references too, once they are there
//   structure           accel/scene/memory_need.h; what its build takes beyond what the cell takes later
//   image               its sums, its mean, and the copy that is written
//   photons, pixels     integrators/method_memory.h
//
// A cell whose forecast exceeds the limit is refused with an error that names the parts and what would take less. One that
// grows beyond it all the same fails after the iteration that did: no image is changed to save memory.
#pragma once

#include "experiments/config/method.h"
#include "framework/scene/needs.h"
#include "framework/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

struct MemoryPart {
  std::string name;
  double bytes = 0;
  std::string leaner = {};  // what takes less; empty: nothing does
};

struct MemoryForecast {
  std::vector<MemoryPart> parts;
  double bytes() const;
  std::string text() const;  // "program and scene 20 MiB, structure 1.1 GiB, ..."
};

// The structure must not be `auto`. Throws Error for wrong parameters.
MemoryForecast forecast_memory(const Scene& scene, const SceneNeeds& needs, const Method& accel, const Method& integrator,
                               ivec2 resolution);

// Throws Error where there is a limit and the forecast is beyond it. `what`: the cell, for the message.
void refuse_over_memory(const std::string& what, const Scene& scene, const SceneNeeds& needs, const Method& accel,
                        const Method& integrator, ivec2 resolution);
// Throws Error where a method's photons would surely take more than the memory that is free, whether a limit was set or not.
void require_room_for_photons(const SceneNeeds& needs, const Method& integrator, ivec2 resolution);
// Throws std::runtime_error where there is a limit and this process has been beyond it, after so many iterations of a cell.
void fail_over_memory(std::uint64_t iterations);

}  // namespace etendue
