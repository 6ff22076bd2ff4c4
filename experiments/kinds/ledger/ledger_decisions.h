// The decisions that the program makes from a scene, by name, and scenes with what parameters cannot switch.
#pragma once

#include "framework/core/error.h"
#include "framework/scene/needs.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace etendue {

struct DecisionPlace {
  const Scene& scene;
  const SceneNeeds& needs;
  ivec2 resolution;
  std::uint64_t samples;
};

struct MadeDecision {
  bool on = false;
  std::string why;
};

struct LedgerDecision {
  std::string name, text;
  MadeDecision (*make)(const DecisionPlace& place);
};

std::span<const LedgerDecision> ledger_decisions();

// Changes the scene, where no parameter switches the component.
struct LedgerEdit {
  std::string name, text;
  std::string decision;  // that is switched
  Scene (*with)(const Scene& scene);
  std::optional<Scene> (*without)(const Scene& scene);  // nullopt where it cannot be taken out
};

std::span<const LedgerEdit> ledger_edits();

}  // namespace etendue
