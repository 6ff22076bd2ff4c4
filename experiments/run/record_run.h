// Cells that end in one record each (of animations, searches, claims and failures): the way from plan to log and report that
// they share.
#pragma once

#include "experiments/run/run.h"
#include "experiments/run/run_directory.h"

#include <functional>
#include <memory>
#include <optional>

namespace etendue {

// What a kind of experiment does with its cells. The record's cell, manifest, status and error are the execution's.
class RecordWork {
 public:
  // Tells how far a cell is, from 0 to 1, and how many steps that took.
  using Progress = std::function<void(double share, std::uint64_t steps)>;

  virtual ~RecordWork() = default;
  virtual void remember(const KindRecord&) {}  // done by an earlier run
  // Before any cell runs, of all cells, so that a file that cannot be read is known at once. May throw: nothing runs then.
  virtual void load(const Cell&) {}
  // The scene of a cell that was loaded, whose records count only as long as it stays as it is; nullopt: none, or one that
  // cannot change.
  struct SceneState {
    std::string name, path;
    std::uint64_t hash = 0;
  };
  virtual std::optional<SceneState> scene(const Cell&) { return std::nullopt; }
  // A record of what is known before the cell runs; it stands in the log whether the cell fails or not.
  virtual std::unique_ptr<KindRecord> begin(const Cell&) = 0;
  // May throw: the cell has failed then.
  virtual void fill(const Cell&, KindRecord&, RunDirectory&, const Progress&) = 0;
  // How often structures disagreed, in what this run filled in.
  virtual std::uint64_t disagreements() const { return 0; }
};

// The manifest names `threads`.
RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work);

}  // namespace etendue
