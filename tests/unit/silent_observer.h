// An observer for runs whose progress nobody watches.
#pragma once

#include "experiments/run/run.h"

namespace etendue {

struct SilentObserver : RunObserver {
  void narrate(const std::string&) override {}
  void status(const std::string&) override {}
  void cell_started(const CellName&, std::size_t, std::size_t) override {}
  void cell_progress(double, std::uint64_t, double) override {}
  void cell_finished(const CellRecord&, const CheckpointRecord*) override {}
};

}  // namespace etendue
