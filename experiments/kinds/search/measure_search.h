// The part of an experiment that compares point or record structures: [points], over photons of the scenes and over squares
// with a dense spot, or [records], over records where a camera sees the scenes (docs/experiment-file.md has the keys). A cell
// is one (set, count, seed). Its times are medians of repetitions in which the structures take turns, on one thread, and the
// answers of all timed queries are compared between the structures.
#pragma once

#include "experiments/config/config.h"
#include "experiments/log/log.h"
#include "framework/scene/scene.h"

#include <functional>
#include <optional>

namespace etendue {

struct SearchChoice final : KindChoice {
  bool records = false;
  std::vector<std::string> structures;
  std::vector<std::uint64_t> counts;
  std::vector<std::uint64_t> neighbours;  // points only
  std::vector<double> variations;         // contrasts or spreads
  double covering = 8;                    // records only
  int queries = 4000, repetitions = 7;

  const char* kind() const { return records ? "records" : "points"; }
};

// One of the sets that an experiment searches.
struct SearchSet {
  std::string name;                  // without the variation: the scene's, or "clustered"
  std::string label;                 // with it
  std::optional<std::size_t> scene;  // index into the experiment's
  std::string varies;                // "contrast", "spread" or ""
  double variation = 0;
};

// Reads the value of the key `points` or `records`. Throws Error.
SearchChoice read_search(const ConfigNode& node, bool records);

// The sets over scenes of these names: for points every scene's, then the clustered ones; for records each scene's with every
// spread.
std::vector<SearchSet> search_sets(const SearchChoice& choice, const std::vector<std::string>& scenes);

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
