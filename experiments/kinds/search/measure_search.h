// Times point and record structures: medians of repetitions in which the structures take turns, on one thread. The answers of
// all timed queries are compared between the structures.
#pragma once

#include "experiments/kinds/search/search_config.h"
#include "experiments/log/log.h"
#include "framework/scene/scene.h"

#include <functional>

namespace etendue {

struct SearchFigure {
  std::string structure;
  std::string measure;   // points: "build", "within", "nearest", "memory"; records: "insert", "covering", "memory"
  double parameter = 0;  // of within and nearest: number of neighbours
  Measured value;        // seconds per point, per query or per record; memory: bytes per point or record
  double found = 0;      // of queries: how many each found on the mean
};

// One line of the log for each cell, which is one set at one size, with all structures: its "scene" is the set, its
// "integrator" the size.
struct SearchRecord final : KindRecord {
  static constexpr const char* type = "search";

  std::string kind;    // "points" or "records"
  std::string set;     // without the variation
  std::string varies;  // "contrast", "spread" or "" where the set has no such parameter
  double variation = 0;
  std::uint64_t count = 0;
  std::uint64_t checked = 0, disagreements = 0;  // answers compared, and those that differed
  std::vector<SearchFigure> figures;

  std::string line() const override;
};

struct SearchTask {
  const SearchChoice& choice;
  const SearchSet& set;
  const Scene* scene = nullptr;  // of the set; null where it has none
  std::uint64_t count = 0, seed = 1;
  std::function<void(double share)> progress = {};
};

// `cell`, `manifest` and `status` are the caller's to fill. Throws Error.
SearchRecord measure_search(const SearchTask& task);

}  // namespace etendue
