// Cells that end in one record each (of animations, searches, claims and failures): the way from plan to log and report that
// they share.
#pragma once

#include "experiments/run/run.h"
#include "experiments/run/run_directory.h"

#include <optional>

namespace etendue {

// What a kind of experiment does with its cells. `Record` is one of those that RunLog lists: it has a cell, a manifest, a
// status and an error, which are the execution's.
template <class Record>
class RecordWork {
 public:
  // Tells how far a cell is, from 0 to 1, and how many steps that took.
  using Progress = std::function<void(double share, std::uint64_t steps)>;

  virtual ~RecordWork() = default;
  virtual void remember(const Record&) {}  // done by an earlier run
  // Before any cell runs, of all cells, so that a file that cannot be read is known at once. May throw: nothing runs then.
  virtual void load(const Cell&) {}
  // The scene of a cell that was loaded, whose records count only as long as it stays as it is; nullopt: none, or one that
  // cannot change.
  struct SceneState {
    std::string name, path;
    std::uint64_t hash = 0;
  };
  virtual std::optional<SceneState> scene(const Cell&) { return std::nullopt; }
  // What stands in the record whether its cell fails or not.
  virtual void describe(const Cell&, Record&) {}
  // May throw: the cell has failed then.
  virtual void fill(const Cell&, Record&, RunDirectory&, const Progress&) = 0;
  // Of structures, in what this run filled in.
  virtual std::uint64_t disagreements() const { return 0; }
  virtual std::string summary(const RunLog&) const = 0;
};

// `threads`: of the manifest. Defined for each of RunLog's records.
template <class Record>
RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork<Record>& work);

}  // namespace etendue
