// The rows of [[ledger]]: components of the program, and how each is switched.
//
//   component  what is switched, in words
//   method     the method that has it, as the program runs it; default "path"
//   accel      instead, the ray structure that has it, beneath path tracing
//   edit       instead, what is changed in the scene, beneath path tracing
//   on, off    parameters that switch it, put in the place of those of the method or structure; with `name`, another one
//   decided    the decision that the program makes of it from the scene; default: its own parameters are those of `on` or `off`
//   samples    iterations; default: the budget's
//   kept       why the decision stands where the ledger contradicts it
#pragma once

#include "experiments/config/config.h"
#include "experiments/kinds/ledger/ledger_decisions.h"

#include <optional>
#include <vector>

namespace etendue {

struct LedgerRow {
  std::string component, kept;
  Method method, accel;                 // as the program runs them
  std::optional<Method> with, without;  // in the place of the accel where `of_structure`, else of the method; none with an edit
  bool of_structure = false;
  const LedgerEdit* edit = nullptr;
  const LedgerDecision* decision = nullptr;  // null: `always_on` says what is decided
  bool always_on = false;
  std::uint64_t samples = 0;

  // What records call that which has the component.
  std::string owner() const { return (of_structure ? accel : method).label(); }
};

struct LedgerChoice final : KindChoice {
  std::vector<LedgerRow> rows;
};

// `samples`: of the budget. Throws Error.
LedgerChoice read_ledger(const ConfigNode& ledger, std::uint64_t samples);

}  // namespace etendue
