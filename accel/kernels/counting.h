// Counting the work of a traversal, as a template parameter: without it nothing of it is left in the code.
#pragma once

#include "framework/query.h"

namespace etendue {

struct CountNothing {
  static constexpr bool of_primitives = false;
  void node() {}
  void primitives(std::uint32_t) {}
};

struct CountNodes {
  static constexpr bool of_primitives = false;
  std::uint32_t& nodes;

  void node() { ++nodes; }
  void primitives(std::uint32_t) {}
};

struct CountWork {
  static constexpr bool of_primitives = true;
  TraversalCounters& counters;

  void node() { ++counters.nodes; }
  void primitives(std::uint32_t count) { counters.primitives += count; }
};

}  // namespace etendue
