// The part of an experiment that compares point or record structures: [points], over photons of the scenes and over squares
// with a dense spot, or [records], over records where a camera sees the scenes (docs/experiment-file.md has the keys). A cell
// is one (set, count, seed). Structures take turns within it, on one thread.
#pragma once

#include "experiments/config/config.h"

#include <optional>
#include <string>
#include <vector>

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

}  // namespace etendue
