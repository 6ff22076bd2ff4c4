// Times point and record structures: medians of repetitions in which the structures take turns, on one thread. The answers of
// all timed queries are compared between the structures.
#pragma once

#include "experiments/kinds/search/search_config.h"
#include "experiments/kinds/search/search_record.h"
#include "framework/scene/scene.h"

#include <functional>

namespace etendue {

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
