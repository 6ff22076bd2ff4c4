// `etendue inspect --pilot`: which method and structure a scene asks for, how long they take on this machine, what memory, and
// what threatens them.
#pragma once

#include "accel/scene/auto_structure.h"
#include "experiments/config/budget.h"
#include "framework/scene/needs.h"
#include "integrators/choice/choose.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

// Holds what two short renders with different seeds tell of a method. Their difference is its noise; its bias shows in neither.
struct MeasuredNoise {
  double relmse = 0;  // of one of them
  double iterations = 0, prepare_s = 0, iteration_s = 0;
  double exponent = -1;  // of the error over iterations, as the method declares it
  std::uint64_t memory_bytes = 0;

  double seconds_to(double wanted) const;
};

struct Advice {
  std::string budget;
  PilotFindings findings;
  MethodChoice method, structure;
  double build_s = 0;  // of the structure
  std::uint64_t structure_bytes = 0;
  std::optional<MeasuredNoise> noise = {};  // empty: the two images are equal
  std::vector<std::string> hazards = {};
};

// `budget` is what is asked for, of which `error` may be set alone.
Advice advise(const Scene& scene, const SceneNeeds& needs, const Budget& budget, int threads);

}  // namespace etendue
