// The cells of an experiment, in the order in which they run.
#pragma once

#include "experiments/config/cell_name.h"
#include "experiments/config/config.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct Cell {
  std::size_t scene = 0, accel = 0, integrator = 0;  // indices into the config, or as the kind has it
  CellName name;
};

// The experiment's kind lists them.
std::vector<Cell> make_cells(const ExperimentConfig& config);

// Makes scenes x structures x methods x seeds. Seeds are outermost and methods innermost: methods alternate (A B A B), so that
// a machine that slows down or heats up slows all of them.
std::vector<Cell> make_matrix(const ExperimentConfig& config, const std::vector<Method>& methods);

// Those whose key() the ECMAScript regular expression finds. Throws Error on a bad expression or when none is left.
std::vector<Cell> filter_cells(const std::vector<Cell>& cells, const std::string& regex);

struct Shard {
  int index = 0, count = 1;  // index in 0 .. count - 1

  // "i/n" or "slurm"; throws Error.
  static Shard parse(const std::string& text);
  // Reads SLURM_ARRAY_TASK_ID, _MIN, _MAX, _STEP and _COUNT; nullopt outside a Slurm array.
  static std::optional<Shard> from_slurm();
};

// Shards are a partition: each position is in exactly one, and their sizes differ by one at most. Blocks of `count` rotate, so
// that where the count divides the number of methods a machine still gets some cells of each.
bool in_shard(std::size_t position, const Shard& shard);
std::vector<Cell> shard_cells(const std::vector<Cell>& cells, const Shard& shard);

}  // namespace etendue
