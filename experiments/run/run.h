// An experiment from its TOML to its report: plan, then execute. Killing it at any moment loses at most the cell it is in; the
// same plan executed again goes on from there.
#pragma once

#include "experiments/config/cells.h"
#include "experiments/config/config.h"
#include "experiments/log/log.h"
#include "experiments/run/run_cell.h"
#include "framework/io/scene_files.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct RunOptions {
  std::string experiment;
  std::vector<std::string> overrides;
  std::string out;     // "": out/<name of the experiment>[-quick][-shard-i-of-n]
  std::string filter;  // "": all cells
  std::string shard;   // "": what Slurm says, else all cells
  std::optional<int> threads;
  bool fresh = false, quick = false;
  SceneReading reading;  // which files scenes may name, and what of them may be approximated
};

struct RunPlan {
  ExperimentConfig config;
  std::vector<Cell> cells;  // of this shard, after the filter
  Shard shard;
  std::string directory;
  int threads = 1;
  bool fresh = false;
  SceneReading reading = {};
  std::string filter = {};
  std::size_t all_cells = 0;  // of all shards
  std::string options = {};   // of what was typed beside the experiment's file, what changes figures
};

// Reads and checks everything that can be checked without running. Throws Error.
RunPlan plan_run(const RunOptions& options);
// Figures below a folder called results must name the code that gave them: throws Error for a commit that is "-dirty" there.
void refuse_changed_sources(const std::string& directory, const std::string& commit);

// Receives the progress of a run.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  virtual void narrate(const std::string& line) = 0;
  void warn(const std::string& what) { narrate("warning: " + what); }
  virtual void status(const std::string& line) = 0;  // transient: the next one replaces it
  virtual void cell_started(const CellName& cell, std::size_t position, std::size_t count) = 0;  // position from 0
  virtual void cell_progress(double share, std::uint64_t iterations, double time_s) = 0;
  // Does somebody look? Then cells tell what they do before each cell_progress.
  virtual bool watches() const { return false; }
  virtual void cell_live(const LiveFigures&) {}
  virtual void cell_finished(const CellRecord& cell, const CheckpointRecord* last) = 0;
};

// Several kinds of experiments share these first steps, which are reported to the observer.
ManifestRecord plan_manifest(const RunPlan& plan, int threads);
PlanRecord plan_record(const RunPlan& plan, const ManifestRecord& manifest);
Scene load_choice(const RunPlan& plan, const SceneChoice& choice, RunObserver& observer);  // its warnings; throws Error
void narrate_skipped(const RunPlan& plan, std::size_t skipped, RunObserver& observer);

struct RunSummary {
  std::size_t done = 0, failed = 0, skipped = 0;  // skipped: done by an earlier run
  std::uint64_t disagreements = 0;                // of structures, in this run's comparisons
  std::vector<std::string> report_files;
  std::vector<std::string> findings, notes;  // of the report: what is not to be believed, and what was put right
  std::string table;                         // the summary, for people
};

// Writes the report of what the directory holds now, and fills in what the summary tells of it.
void report_run(const RunPlan& plan, RunSummary& summary);
// Says why a cell's work fails; nullopt where it does not. Work that was suspended is done again, since its clock ran on
// meanwhile; where that happens three times in a row, it has failed.
std::optional<std::string> failure_of(const std::function<void()>& work, RunObserver& observer);

// Throws Error; a failing cell is recorded and counted instead. `compute` does the work of a cell: tests put failures there.
using CellFunction = std::function<CellResult(const CellTask&)>;
RunSummary execute_run(const RunPlan& plan, RunObserver& observer, const CellFunction& compute = run_cell);

}  // namespace etendue
